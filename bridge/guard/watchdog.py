"""The watchdog: counts the cycles since the last command of a controller that holds the robot."""

from __future__ import annotations

from typing import Literal

from bridge.guard.config import WatchdogSettings


class Watchdog:
    """One update per cycle; counts from the first command on.

    Args:
        settings: the bounds.
    """

    def __init__(self, settings: WatchdogSettings) -> None:
        self._s = settings
        self._silent: int | None = None

    def reset(self) -> None:
        """Wait for the next command before counting again."""
        self._silent = None

    def heard(self) -> None:
        """The controller gave another sign of life; one that sent no command yet is not watched."""
        if self._silent is not None:
            self._silent = 0

    def update(self, *, received: bool, supervised: bool) -> Literal["", "close", "hold", "descend"]:
        """One cycle.

        Args:
            received: a command came.
            supervised: somebody holds the robot, or died holding it.

        Returns:
            What the silence so far asks for: nothing, that a quick step ends, that the joints hold, or that
            the robot goes down.
        """
        if received:
            self._silent = 0
        elif not supervised:
            self._silent = None
        elif self._silent is not None:
            self._silent += 1
        silent = self._silent or 0
        if not self._s.enabled or silent < self._s.stride_cycles:
            return ""
        if silent < self._s.silence_cycles:
            return "close"
        return "hold" if silent < self._s.silence_cycles + self._s.hold_cycles else "descend"
