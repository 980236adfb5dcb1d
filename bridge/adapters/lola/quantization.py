"""The steps in which a real LoLA's values come, taken from captured packets of V6 robots.

Confirmed on two packets of two robots: all accelerometer and gyroscope values are whole multiples of the steps,
and the 46 joint values lie within 0.003 steps of theirs. Values that are whole steps already stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

POSITION_STEP: Final = 0.001534
"""rad; 2 pi / 4096 as the firmware rounds it."""
RESIDUE: Final = 4.2e-5
"""rad by which each joint's values are off whole steps."""
RESIDUE_SIGNS: Final = (-1, -1, -1, -1, -1, 1, -1, 1, 1, 1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, -1, 1, -1)
"""Of the joints that are angles, in frame order; the same on both robots."""
HAND_STEP: Final = 0.0004
"""Of a hand's opening (assumed: all four captured values are multiples of it)."""
GYROSCOPE_STEP: Final = math.radians(500.0) / 32768.0
"""rad/s"""
ACCELEROMETER_STEP: Final = 9.81 / 1024.0
"""m/s^2"""
_STEPS: Final = {"Gyroscope": GYROSCOPE_STEP, "Accelerometer": ACCELEROMETER_STEP}


def quantized(key: str, values: Sequence[float]) -> Sequence[float]:
    """An array of a sensor packet as a real robot would report it.

    Args:
        key: of the array in the packet.
        values: of the array.
    """
    if key == "Position":
        return _positions(values)
    return _whole_steps(values, _STEPS[key]) if key in _STEPS else values


def _positions(angles: Sequence[float]) -> list[float]:
    """Joint angles (rad; the last two slots are hands, 0 to 1) as the encoders of a V6 would report them."""
    shifts = [sign * RESIDUE for sign in RESIDUE_SIGNS]
    joints = [
        round((a - shift) / POSITION_STEP) * POSITION_STEP + shift
        for a, shift in zip(angles, shifts, strict=False)
    ]
    return [*joints, *_whole_steps(angles[len(shifts) :], HAND_STEP)]


def _whole_steps(values: Sequence[float], step: float) -> list[float]:
    return [round(value / step) * step for value in values]
