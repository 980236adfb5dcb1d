"""Buttons, bumpers and touch surfaces: pressed from outside, the bumpers also by what the feet run into."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from bridge.errors import ConfigurationError

TOUCH: Final = (
    "chest",
    "head_front",
    "head_middle",
    "head_rear",
    "left_bumper_left",
    "left_bumper_right",
    "left_hand_back",
    "left_hand_left",
    "left_hand_right",
    "right_bumper_left",
    "right_bumper_right",
    "right_hand_back",
    "right_hand_left",
    "right_hand_right",
)
"""In the order of `SensorFrame.touch`."""


class Touch:
    """State of all buttons."""

    def __init__(self) -> None:
        self._pressed = [0.0] * len(TOUCH)

    def press(self, name: str, value: float = 1.0) -> None:
        """Press a button until it is set to 0 again.

        Args:
            name: One of `TOUCH`.
            value: 1 pressed, 0 released.

        Raises:
            ConfigurationError: no such button, or another value.
        """
        if name not in TOUCH:
            raise ConfigurationError(f"No button `{name}`; known are {', '.join(TOUCH)}.")
        if value not in (0.0, 1.0):
            raise ConfigurationError(f"Button `{name}` set to {value}; 0 or 1 is expected.")
        self._pressed[TOUCH.index(name)] = float(value)

    def read(self, bumped: Iterable[str]) -> tuple[float, ...]:
        """All buttons, 0 or 1.

        Args:
            bumped: Bumpers that something pushes now.
        """
        pressed = self._pressed.copy()
        for name in bumped:
            pressed[TOUCH.index(name)] = 1.0
        return tuple(pressed)
