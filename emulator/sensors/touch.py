"""Buttons, bumpers and touch surfaces: pressed from outside, the bumpers also by contacts of the feet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from bridge.errors import ConfigurationError
from bridge.types import Side, Vec3
from emulator.engine.values import FootLoad

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
TOE: Final = 0.06
"""Bumpers cover the foot in front of this x, m (assumed; they sit at 0.0876)."""
BUMPER_MIDDLE: Final[dict[Side, float]] = {"L": 0.0025, "R": -0.0025}
"""y between the left and the right bumper of a foot, AnkleRoll frame, m (data sheet: 0.019 and -0.014)."""


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

    def read(self, feet: Mapping[Side, FootLoad]) -> tuple[float, ...]:
        """All buttons, 0 or 1; the bumpers from the points at which something pushes on the rim of a foot."""
        pressed = self._pressed.copy()
        for side, load in feet.items():
            if load.rim:
                for name in _bumped(side, load.rim):
                    pressed[TOUCH.index(name)] = 1.0
        return tuple(pressed)


def _bumped(side: Side, rim: Iterable[Vec3]) -> set[str]:
    """Bumpers of a foot that something pushes at these points, AnkleRoll frame."""
    foot = "left" if side == "L" else "right"
    sides = {"left" if point[1] > BUMPER_MIDDLE[side] else "right" for point in rim if point[0] > TOE}
    return {f"{foot}_bumper_{bumper}" for bumper in sides}
