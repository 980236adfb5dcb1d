"""A process of the robot's cycle and priority that does nothing else: the machine's share of a lateness."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
from array import array
from pathlib import Path
from typing import Final

import numpy as np

from bridge.realtime import ROBOT_PRIORITY, quiet_process
from bridge.types import Array
from emulator.timing import CycleTimer
from tests.loops import repeat_while

MAX_CYCLES: Final = 1_000_000
"""Cycles after which it ends without its parent, too."""


class BareLoop:
    """Waits for one deadline after the other, in a process of its own, until the context ends."""

    def __init__(self) -> None:
        self.lateness: Array = np.empty(0)
        """Lateness of each deadline, s, shape (n,); there when the context has ended."""

    def __enter__(self) -> BareLoop:
        self._folder = tempfile.TemporaryDirectory()
        self._file = Path(self._folder.name) / "lateness.npy"
        command = [sys.executable, "-m", "tests.bare_loop", str(self._file)]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, cwd=Path(__file__).parents[1])
        assert self._process.stdout is not None
        self._process.stdout.readline()  # it begins
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.communicate()
        self.lateness = np.load(self._file)
        self._folder.cleanup()


def main() -> None:
    """Wait for 10 ms deadlines until SIGTERM, then write the file that is named on the command line."""
    ended: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ended.append(number))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C is the parent's
    timer, late = CycleTimer(0.01), array("d")
    quiet_process(ROBOT_PRIORITY)
    print("begins", flush=True)
    timer.restart()
    for _ in repeat_while(lambda: not ended, MAX_CYCLES):
        late.append(timer.wait())
    np.save(sys.argv[1], np.array(late))


if __name__ == "__main__":
    main()
