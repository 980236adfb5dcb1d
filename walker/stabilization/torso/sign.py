"""The sign between the thesis' plant and NAO's axes: the only place where it is decided.

AnklePitch turns the foot against the shank about +y (x forward, y left, z up): positive is toe down. With the
sole flat on the ground the foot cannot turn, so the body does, the other way: of the chain
R_torso R_y(HipPitch) R_y(KneePitch) R_y(AnklePitch) = 1 follows AngleY = -(HipPitch + KneePitch + AnklePitch).
A positive AnklePitch tips the body backwards, and AngleY, positive nose down, falls: the plant from AnklePitch
to AngleY has a steady-state gain of -1.

The thesis' plant (4.12) has +1. Its input is therefore the ankle angle counted positive when it tips the body
forwards, called the *lean* here. All designs are made on plants in this sign, so they have positive gains, and
their output is a lean.
"""

from __future__ import annotations

from typing import Final

ANKLE_PITCH_PER_LEAN: Final = -1.0
"""AnklePitch (rad, NAO's axis) that makes 1 rad of lean (positive: the body tips forwards)."""


def ankle_pitch_from_lean(lean: float) -> float:
    """AnklePitch offset, rad, positive toe down, for a lean, rad, positive forwards."""
    return ANKLE_PITCH_PER_LEAN * lean
