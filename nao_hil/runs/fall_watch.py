"""Distinguishes a fall from a robot that lies: it was on its feet, is down now, and was not ordered down."""

from __future__ import annotations

from typing import Final

from bridge.messages import Notice, WalkTelemetry

_ORDERED: Final = ("motion", "rest")
"""States of the walker in which the robot goes down, or is down, as it was told."""
_GUARD_CODES: Final = ("guard-sit", "guard-active", "guard-approach", "guard-idle")


class FallWatch:
    """Follows one robot, message by message; one that began lying or sitting has not fallen."""

    def __init__(self) -> None:
        self.state = ""
        """The walker's, by its newest word."""
        self._seated = False
        """The guard has it sit down, or sitting."""
        self._up = False
        """On its feet in the last cycle."""

    def telemetry(self, message: WalkTelemetry) -> None:
        """Take in the walker's telemetry."""
        self.state = message.state

    def notice(self, message: Notice) -> None:
        """Take in the robot's notices: its guard may sit it down."""
        if message.code in _GUARD_CODES:
            self._seated = message.code == "guard-sit"

    def restart(self) -> None:
        """The robot was put elsewhere, as it may lie now."""
        self._up = False

    def update(self, *, down: bool) -> bool:
        """One cycle: whether the robot falls in it.

        Args:
            down: it is not on its feet.
        """
        falls = down and self._up and self.state not in _ORDERED and not self._seated
        self._up = not down
        return falls
