"""Robot and walker of `nao-hil up` as two processes; a walker that serves is started again when it ends."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from typing import Final

from bridge.errors import LinkError
from bridge.messages import SensorFrame
from nao_hil.runs.announcer import WALKER_ENDED, Announcer
from nao_hil.runs.folder import RunDirectory
from nao_hil.runs.supervisor import Child, ChildResult

END_TIMEOUT: Final = 30.0
"""s until a side that is asked to end must have ended."""
MAX_RESTARTS: Final = 3
"""Restarts of the walker within `RESTART_WINDOW`; more have a cause that a restart keeps."""
RESTART_WINDOW: Final = 60.0
"""Window in which restarts are counted, s."""
_USAGE_EXIT_CODE: Final = 2
"""Exit code of a configuration that a restart does not mend."""


class Sides:
    """Robot and walker as two processes.

    Args:
        directory: Folder of the run.
        name: Id of the robot.
        listen: Zenoh endpoint of the robot.
        serve: The walker waits for commands, and is started again when it ends.
    """

    def __init__(self, directory: RunDirectory, name: str, listen: str, *, serve: bool) -> None:
        directory.release()  # the robot's process takes it
        self._folder, common = directory.path, ["--name", name, "--config", str(directory.config), "--json"]
        self._robot = Child(
            "robot", ["emulate", "--listen", listen, "--out", str(self._folder), *common], self._folder
        )
        self._serve = serve
        self._walk = ["walk", "--connect", listen, *(["--serve"] if serve else []), *common]
        self._walker = Child("walker", self._walk, self._folder)
        self._announcer = Announcer(name, listen)
        self._began: deque[float] = deque(maxlen=MAX_RESTARTS)
        """Times of the last restarts, s."""
        self._count = 0
        self.given_up = False
        """Whether the walker ended too often."""

    @property
    def running(self) -> bool:
        """Whether the run continues: both are running, or the robot is and its walker serves."""
        if not self._robot.running:
            return False
        return self._walker.running or (self._serve and self._walker.end(0.0).code != _USAGE_EXIT_CODE)

    def restart_walker(self, frame: SensorFrame | None) -> str:
        """Start a serving walker again that has ended; call it regularly.

        Args:
            frame: Newest of the robot; None: it has sent none yet.

        Returns:
            The sentence that the page shows as well; empty: no restart.
        """
        if self.given_up or not self.running or self._walker.running:
            return ""
        now, why = time.monotonic(), self._walker.end(0.0).error.rstrip(".")
        self.given_up = len(self._began) == MAX_RESTARTS and now - self._began[0] < RESTART_WINDOW
        if self.given_up:
            sentence = (
                f"The walker ended {MAX_RESTARTS + 1} times within a minute, at last because {why}; it is not "
                f"started again. The robot stays without a walker; `nao-hil walk --serve` gives it one."
            )
        else:
            self._began.append(now)
            self._count += 1
            sentence = f"The walker ended: {why}. A new one starts; until it has the robot, the guard has it."
            self._walker = Child(f"walker-{self._count + 1}", self._walk, self._folder)
        if frame is not None:
            with contextlib.suppress(LinkError):  # the robot ended meanwhile
                self._announcer.announce(WALKER_ENDED, sentence, frame.seq)
        return sentence

    def end(self) -> tuple[ChildResult, ChildResult]:
        """End both, and give the results of walker and robot."""
        # Both at once; a walker that ended by itself has already stopped the robot at a stand.
        self._walker.ask_to_end()
        self._robot.ask_to_end()
        self._announcer.close()
        walker = self._walker.end(END_TIMEOUT)
        return walker, self._robot.end(END_TIMEOUT)
