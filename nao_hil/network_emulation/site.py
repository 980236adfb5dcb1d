"""Two network namespaces that see only each other, joined by an emulated link; needs root and iproute2."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import subprocess
from pathlib import Path
from types import TracebackType
from typing import Final

from bridge.errors import LinkError
from nao_hil.network_emulation.link import EmulatedLink

ROBOT_ADDRESS: Final = "10.199.0.1"
WALKER_ADDRESS: Final = "10.199.0.2"
"""In namespaces of their own: they are in nobody's way."""
_numbers: Final = itertools.count()


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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _clear() -> None:
    """Take down what processes left that were killed: a namespace's name has the number of its process."""
    listed = subprocess.run(("ip", "netns", "list"), capture_output=True, text=True, check=False).stdout
    for space, number in re.findall(r"^(nao-hil-[rw]([0-9a-f]+)-[0-9a-f]+)\b", listed, re.MULTILINE):
        if not Path(f"/proc/{int(number, 16)}").exists():
            subprocess.run(("ip", "netns", "del", space), capture_output=True, check=False)


def _ip(*arguments: str) -> None:
    done = subprocess.run(("ip", *arguments), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise LinkError(f"`ip {' '.join(arguments)}` failed: {done.stderr.strip()}; run this as root on Linux.")
