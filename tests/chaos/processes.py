"""The processes of the rough test: three robots and their clients, started again whenever one ends."""

from __future__ import annotations

import contextlib
import signal
import socket
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

import msgpack

from nao_hil.runs.supervisor import Child
from tests.processes import memory

PACKET: Final = 896
"""bytes of a packet of LoLA."""
READY_WORDS: Final = ("recording to", "recording `", " found: ", "the page is at")
"""Of which each process says one when it has loaded."""
TAG: Final = 0.3
"""rad of HeadYaw, which the client of LoLA alone asks for."""


class Member:
    """One process; each start has a folder of its own.

    Args:
        name: of the process.
        command: gives the arguments of `nao-hil` for a folder.
        folder: for its folders.
        robot: number of the robot that it is, or serves.
    """

    def __init__(self, name: str, command: Callable[[Path], list[str]], folder: Path, robot: int) -> None:
        self.name, self.robot = name, robot
        self._command, self._folder = command, folder
        self._starts = 0
        self.excused = 0.0
        """Monotonic time until which it may end with a sentence: something was done to it, or to its robot."""
        self.memory: list[tuple[float, float]] = []
        """Monotonic time and MB of its present start, one per look since it was ready."""
        self.start()

    def start(self) -> None:
        """Start it, or start it again."""
        self._starts += 1
        self.folder = self._folder / f"{self.name}-{self._starts}"
        self.folder.mkdir(parents=True)
        self.child = Child(self.name, self._command(self.folder), self.folder)
        self.memory = []
        self._ready = False

    @property
    def log(self) -> str:
        """Its stderr, without the line breaks of a terminal."""
        return " ".join(self.child.stderr.split())

    def signal(self, number: signal.Signals) -> None:
        """Send a signal, if it still runs."""
        if self.child.running:
            self.child._process.send_signal(number)

    def look(self) -> None:
        """Note its memory, once it has loaded: that takes minutes on a machine without time for it."""
        self._ready = self._ready or any(word in self.log for word in READY_WORDS)
        with contextlib.suppress(OSError, IndexError):  # it ended just now
            if self._ready and self.child.running:
                self.memory.append((time.monotonic(), memory(self.child.pid) / 1e6))


class LolaProgram:
    """A team's program: reads packets and asks for its tag, connects again when it is cut off.

    Args:
        path: of the socket.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.ended = False
        self.packets = 0
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        values = {"Position": [TAG] + [0.0] * 24, "Stiffness": [0.6] * 25}
        answer = msgpack.packb(values, use_single_float=True)
        while not self.ended:
            with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX) as link:
                link.settimeout(1.0)
                link.connect(str(self._path))
                while not self.ended and self._read(link):
                    self.packets += 1
                    link.sendall(answer)
            time.sleep(0.2)

    @staticmethod
    def _read(link: socket.socket) -> bool:
        data = b""
        while len(data) < PACKET:
            piece = link.recv(PACKET - len(data))
            if not piece:
                return False
            data += piece
        return True

    def end(self) -> None:
        """Leave."""
        self.ended = True
        self._thread.join(5.0)
