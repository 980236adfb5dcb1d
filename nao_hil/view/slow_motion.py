"""An emulated robot in slow motion: its world is paused and stepped by the clock."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final

from bridge.errors import NaoHilError
from bridge.messages.world import Pause, Resume, Step, WorldCommand

SPEEDS: Final = ("1", "0.5", "0.25", "0.1", "0.05")
"""Robot time per time of the clock."""


class SlowMotion:
    """Steps the world, one cycle at a time.

    Args:
        send: Carries a world command out.
        cycle: The robot's cycle, s.
    """

    def __init__(self, send: Callable[[WorldCommand], object], cycle: float) -> None:
        self._send, self._cycle = send, cycle
        self._end = threading.Event()
        self._pace: threading.Thread | None = None

    def set_speed(self, speed: float) -> str:
        """Go on at this speed; 1: as fast as before.

        Returns:
            What came of it, in a sentence.

        Raises:
            FrameError: refused.
            LinkError: no robot answers.
        """
        self.stop()
        if speed >= 1.0:
            self._send(Resume())
            return "The robot's time goes on at full speed."
        self._send(Pause())
        self._end.clear()
        self._pace = threading.Thread(target=self._run, args=(self._cycle / speed,), name="slow", daemon=True)
        self._pace.start()
        return f"The robot's time goes at {speed:g} of its speed."

    def end(self) -> None:
        """The page ends: a world that it slowed down goes on. Raises as `set_speed`."""
        if self._pace is not None:
            self.set_speed(1.0)

    def stop(self) -> None:
        """Step no more, once a step that is under way is done; the world stays as it is."""
        pace, self._pace = self._pace, None
        if pace is not None:
            self._end.set()
            pace.join()

    def _run(self, pause: float) -> None:
        while not self._end.wait(pause):
            try:
                self._send(Step())
            except NaoHilError:  # the robot is gone, or was told to go on
                return
