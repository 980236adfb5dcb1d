"""Plates under the swing foot, drawn anew for each seed."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from bridge.messages.world import PlateUnderFoot

LENGTH: Final = (0.08, 0.20)
"""m"""
WIDTH: Final = (0.04, 0.10)
"""m"""
YAW: Final = math.radians(45.0)
"""Largest turn against the foot, rad."""
AHEAD: Final = (0.0, 0.06)
"""Middle of the plate ahead of the lifted sole's, m."""
OUTWARD: Final = (0.0, 0.05)
"""Middle of the plate outward of it, m."""
INWARD_REACH: Final = 0.045
"""Farthest that a plate may reach inward of the sole's middle, m: the other foot stands there."""
_TRIES: Final = 1000
COVERED_BEHIND: Final = (0.08, 0.10)
"""Rear edge of a plate that covers the sole, behind the lifted sole's middle, m."""
COVERED_AHEAD: Final = (0.16, 0.20)
"""Its front edge ahead of it, m: the sole comes down a step farther."""
COVERED_OUTWARD: Final = (0.055, 0.090)
"""Its outer edge outward of it, m."""


def drawn_plate(seed: int, height: float) -> PlateUnderFoot:
    """A plate under the right foot whose size, place and angle follow from the seed; uniform draws.

    Args:
        seed: Of the walk.
        height: Of the plate, m.
    """
    draw = np.random.default_rng(seed).uniform
    for _ in range(_TRIES):
        length, width, yaw = draw(*LENGTH), draw(*WIDTH), draw(-YAW, YAW)
        ahead, outward = draw(*AHEAD), draw(*OUTWARD)
        half = 0.5 * (length * abs(math.sin(yaw)) + width * math.cos(yaw))
        if half - outward <= INWARD_REACH:
            return PlateUnderFoot(foot="right", size=(length, width, height), shift=(ahead, -outward), yaw=yaw)
    raise AssertionError("no plate fits beside the other foot")


def covering_plate(seed: int, height: float) -> PlateUnderFoot:
    """A plate that the whole right foot stands on; its edges follow from the seed, uniform draws.

    Args:
        seed: Of the walk.
        height: Of the plate, m.
    """
    draw = np.random.default_rng(seed).uniform
    behind, ahead, outward = draw(*COVERED_BEHIND), draw(*COVERED_AHEAD), draw(*COVERED_OUTWARD)
    return PlateUnderFoot(
        foot="right",
        size=(behind + ahead, INWARD_REACH + outward, height),
        shift=(0.5 * (ahead - behind), 0.5 * (INWARD_REACH - outward)),
        yaw=0.0,
    )
