"""An IP link between two tunnel devices with emulated network conditions; Linux only.

The devices are made here and moved into their namespaces by `Site`; processes inside see a plain IP link.
"""

from __future__ import annotations

import contextlib
import fcntl
import heapq
import itertools
import os
import selectors
import struct
import threading
import time
from typing import Final

import numpy as np

from bridge.errors import LinkError
from nao_hil.network_emulation.channel import Channel, NetworkConditions

_TUNSETIFF: Final = 0x400454CA
_IFF_TUN: Final = 0x0001
_IFF_NO_PI: Final = 0x1000
_LONGEST: Final = 65536
_PRIORITY: Final = 60
"""SCHED_FIFO: over robot and walker, for a network is never late for lack of a processor."""


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
                packet = os.read(self._ends[side], _LONGEST)
            except OSError:  # no more for now, or the end is down
                return
            at = self._channels[side].arrival(time.monotonic(), len(packet))
            if at is not None:
                heapq.heappush(waiting, (at, next(number), side, packet))

    def close(self) -> None:
        """End the thread; the devices go with their descriptors."""
        os.write(self._woken, b"x")
        self._thread.join()
        for descriptor in (*self._ends, self._wake, self._woken):
            os.close(descriptor)
