"""Buttons, bumpers and touch surfaces: pressed from outside, the bumpers also by contacts of the feet."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from bridge.errors import ConfigurationError
from bridge.types import Side, Vec2, Vec3
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
BUMPERS: Final[dict[Side, dict[str, Vec2]]] = {
    "L": {"left": (0.0876, 0.019), "right": (0.0876, -0.014)},
    "R": {"left": (0.0876, 0.014), "right": (0.0876, -0.019)},
}
"""Places of the switches, AnkleRoll frame, x and y, m (vendor's hardware pages and URDFs)."""
REACH: Final = 0.035
"""How far from its place a push on the rim presses a bumper, m (assumed: the two shells cover the toes)."""


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
    pressed = set()
    for point in rim:
        distance, bumper = min((math.dist(point[:2], place), name) for name, place in BUMPERS[side].items())
        if distance < REACH:
            pressed.add(f"{foot}_bumper_{bumper}")
    return pressed
