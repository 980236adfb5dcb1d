"""Two network namespaces, joined by an emulated link between two tunnel devices; needs root and iproute2."""

from __future__ import annotations

import contextlib
import fcntl
import heapq
import itertools
import os
import re
import selectors
import shutil
import struct
import subprocess
import threading
import time
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from bridge.errors import LinkError

QUEUE_SIZE = 1000
"""Packets that wait when the rate is limited; more are dropped."""


class NetworkConditions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Conditions of one direction; the default passes every packet on at once."""

    delay: float = 0.0
    """s"""
    jitter: float = 0.0
    """s; the delay is drawn from `delay` +- `jitter`."""
    loss: float = 0.0
    """Fraction of packets that never arrive, 0 to 1."""
    reorder: float = 0.0
    """Fraction of packets that are not delayed at all; without any, jitter never changes the order."""
    rate: float = 0.0
    """bit/s; 0: no bound."""
    outage: bool = False
    """Nothing arrives."""


class Channel:
    """Computes when each packet of one direction arrives.

    Args:
        conditions: Initial ones; the attribute `conditions` may be set at any time.
        generator: Source of jitter, loss and reordering.
    """

    def __init__(self, conditions: NetworkConditions, generator: np.random.Generator) -> None:
        self.conditions = conditions
        self._random = generator
        self._link_free = 0.0
        self._last = 0.0

    def arrival(self, now: float, size: int) -> float | None:
        """Time at which a packet of `size` bytes sent at `now` arrives, s; None: never."""
        w = self.conditions
        lost, early, shift = map(float, self._random.random(3))
        if w.outage or lost < w.loss:
            return None
        sent = now
        if w.rate > 0.0:
            duration = 8.0 * size / w.rate
            if self._link_free - now > QUEUE_SIZE * duration:
                return None
            sent = self._link_free = max(now, self._link_free) + duration
        if early < w.reorder:
            return sent
        at = sent + max(0.0, w.delay + w.jitter * (2.0 * shift - 1.0))
        self._last = at = max(at, self._last)
        return at


_TUNSETIFF: Final = 0x400454CA
_IFF_TUN: Final = 0x0001
_IFF_NO_PI: Final = 0x1000
_MAX_PACKET: Final = 65536
_PRIORITY: Final = 60
"""SCHED_FIFO: over robot and walker, for a network is never late for lack of a processor."""
ROBOT_ADDRESS: Final = "10.199.0.1"
WALKER_ADDRESS: Final = "10.199.0.2"
"""In namespaces of their own, without effect on other networks."""
_numbers: Final = itertools.count()


def open_tunnel(name: str) -> int:
    """File descriptor of a new tunnel device of IP packets.

    Raises:
        LinkError: the system does not permit or know it.
    """
    try:
        descriptor = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
        fcntl.ioctl(descriptor, _TUNSETIFF, struct.pack("16sH22x", name.encode(), _IFF_TUN | _IFF_NO_PI))
    except OSError as error:
        raise LinkError(
            f"Network emulation needs tunnel devices (/dev/net/tun, capability NET_ADMIN): {error.strerror}; "
            "run this as root on Linux."
        ) from None
    return descriptor


class EmulatedLink:
    """Both directions between the devices `ends`, carried by a thread of its own until closed.

    Args:
        ends: Names of the two devices.
        seed: Of jitter, loss and reordering.
    """

    def __init__(self, ends: tuple[str, str], seed: int) -> None:
        first, second = np.random.default_rng(seed).spawn(2)
        self._channels = (Channel(NetworkConditions(), first), Channel(NetworkConditions(), second))
        self._ends = open_tunnel(ends[0]), open_tunnel(ends[1])
        self._wake, self._woken = os.pipe()
        self._thread = threading.Thread(target=self._run, name="emulated link", daemon=True)
        self._thread.start()

    def set(self, conditions: NetworkConditions) -> None:
        """Set the conditions of both directions."""
        for channel in self._channels:
            channel.conditions = conditions

    def _run(self) -> None:
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))  # of this thread alone
        waiting: list[tuple[float, int, int, bytes]] = []
        number = itertools.count()
        selector = selectors.DefaultSelector()
        for side, end in enumerate(self._ends):
            selector.register(end, selectors.EVENT_READ, side)
        selector.register(self._wake, selectors.EVENT_READ, None)
        while True:
            pause = max(0.0, waiting[0][0] - time.monotonic()) if waiting else None
            for key, _ in selector.select(pause):
                if key.data is None:
                    return
                self._take(key.data, waiting, number)
            while waiting and waiting[0][0] <= time.monotonic():
                _, _, side, packet = heapq.heappop(waiting)
                with contextlib.suppress(OSError):  # its end is down
                    os.write(self._ends[1 - side], packet)

    def _take(
        self, side: int, waiting: list[tuple[float, int, int, bytes]], number: itertools.count[int]
    ) -> None:
        while True:
            try:
                packet = os.read(self._ends[side], _MAX_PACKET)
            except OSError:  # no more for now, or the end is down
                return
            at = self._channels[side].arrival(time.monotonic(), len(packet))
            if at is not None:
                heapq.heappush(waiting, (at, next(number), side, packet))

    def close(self) -> None:
        """End the thread; the devices end with their descriptors."""
        os.write(self._woken, b"x")
        self._thread.join()
        for descriptor in (*self._ends, self._wake, self._woken):
            os.close(descriptor)


class Site:
    """The robot's place and the walker's; close it, or use it as a context manager.

    Args:
        seed: Of the emulated link.

    Raises:
        LinkError: no root, no iproute2, or the system has no namespaces or tunnels.
    """

    def __init__(self, seed: int = 0) -> None:
        if shutil.which("ip") is None:
            raise LinkError("Network emulation needs the command `ip`; install iproute2.")
        _clear()
        mark = f"{os.getpid():x}-{next(_numbers):x}"
        self.spaces = f"nao-hil-r{mark}", f"nao-hil-w{mark}"
        self._devices = f"nhr{mark}", f"nhw{mark}"
        self.link = EmulatedLink(self._devices, seed)
        try:
            for space, device, addresses in zip(
                self.spaces,
                self._devices,
                ((ROBOT_ADDRESS, WALKER_ADDRESS), (WALKER_ADDRESS, ROBOT_ADDRESS)),
                strict=True,
            ):
                _ip("netns", "add", space)
                _ip("link", "set", device, "netns", space)
                _ip("-n", space, "addr", "add", addresses[0], "peer", addresses[1], "dev", device)
                _ip("-n", space, "link", "set", device, "up")
                _ip("-n", space, "link", "set", "lo", "up")
        except LinkError:
            self.close()
            raise

    @property
    def robot(self) -> tuple[str, ...]:
        """Command prefix that runs a program in the robot's namespace."""
        return "ip", "netns", "exec", self.spaces[0]

    @property
    def walker(self) -> tuple[str, ...]:
        """Command prefix that runs a program in the walker's namespace."""
        return "ip", "netns", "exec", self.spaces[1]

    def close(self) -> None:
        """Take it all down; processes in there lose their network."""
        self.link.close()
        for space in self.spaces:
            subprocess.run(("ip", "netns", "del", space), capture_output=True, check=False)

    def __enter__(self) -> Site:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _clear() -> None:
    """Remove the namespaces of killed processes: a namespace's name has the number of its process."""
    listed = subprocess.run(("ip", "netns", "list"), capture_output=True, text=True, check=False).stdout
    for space, number in re.findall(r"^(nao-hil-[rw]([0-9a-f]+)-[0-9a-f]+)\b", listed, re.MULTILINE):
        if not Path(f"/proc/{int(number, 16)}").exists():
            subprocess.run(("ip", "netns", "del", space), capture_output=True, check=False)


def _ip(*arguments: str) -> None:
    done = subprocess.run(("ip", *arguments), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise LinkError(f"`ip {' '.join(arguments)}` failed: {done.stderr.strip()}; run this as root on Linux.")
