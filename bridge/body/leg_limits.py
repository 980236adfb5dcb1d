"""Joint limits that leg angles violate, and the range of an ankle."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from typing import Final, NamedTuple

from bridge.body.joints import LEG_JOINTS
from bridge.body.model import Body
from bridge.body.quantities import coupled_limits
from bridge.types import Side

CLIPPED_EXCESS: Final = math.radians(0.5)
"""Excess of a planned angle that is clipped in silence, rad: half the backlash of a good robot's ankle."""
_ANKLE_PITCH_INDEX: Final = 4
"""Place of AnklePitch, to which AnkleRoll's range is coupled, among a leg's six angles."""


class LimitViolation(NamedTuple):
    """One joint outside its range."""

    joint: str
    excess: float
    """Above the upper limit (positive) or below the lower one (negative), rad."""


def limit_violations(body: Body, side: Side, angles: Sequence[float]) -> tuple[LimitViolation, ...]:
    """Joints of a leg outside their ranges, in chain order; AnkleRoll's range depends on AnklePitch.

    Args:
        body: The data sheet.
        side: The leg.
        angles: HipYawPitch, HipRoll, HipPitch, KneePitch, AnklePitch, AnkleRoll, rad.
    """
    violations = []
    for joint, angle in zip(LEG_JOINTS[side], angles, strict=True):
        lower, upper = coupled_limits(body, joint, angles[_ANKLE_PITCH_INDEX])
        excess = max(angle - upper, 0.0) + min(angle - lower, 0.0)
        if excess != 0.0:
            violations.append(LimitViolation(joint, excess))
    return tuple(violations)


class AnkleRange:
    """Ranges of one ankle's two joints, for the control cycle: `coupled_limits` in plain floats.

    Args:
        body: The data sheet.
        side: The leg.
    """

    lower: float
    """Lower end of the range of AnklePitch, rad."""
    upper: float

    def __init__(self, body: Body, side: Side) -> None:
        pitch = body.joints[f"{side}AnklePitch"]
        self.lower, self.upper = pitch.lower, pitch.upper
        rows = body.coupling.LAnkleRoll if side == "L" else body.coupling.RAnkleRoll
        inside = {row.at for row in rows if self.lower < row.at < self.upper}
        # Straight between these places. Where the joint's own range cuts a row's line between two of them (2e-4
        # rad on an H21), the straight line lies inside the true range, because that range is convex there.
        self._at = sorted(inside | {self.lower, self.upper})
        self._ends = [coupled_limits(body, f"{side}AnkleRoll", at) for at in self._at]

    def clip_pitch(self, pitch: float) -> float:
        """AnklePitch within its range, rad."""
        return min(max(pitch, self.lower), self.upper)

    def clip_roll(self, roll: float, pitch: float) -> float:
        """AnkleRoll within the range that it has at an AnklePitch, rad.

        Args:
            roll: AnkleRoll, rad.
            pitch: AnklePitch within its own range, rad.
        """
        lower, upper = self.roll_range(pitch)
        return min(max(roll, lower), upper)

    def roll_range(self, pitch: float) -> tuple[float, float]:
        """Lower and upper end of AnkleRoll's range at an AnklePitch within its own range, rad."""
        i = min(bisect_right(self._at, pitch), len(self._at) - 1)
        a, b = self._at[i - 1], self._at[i]
        share = (pitch - a) / (b - a)
        (lower_a, upper_a), (lower_b, upper_b) = self._ends[i - 1], self._ends[i]
        return lower_a + share * (lower_b - lower_a), upper_a + share * (upper_b - upper_a)
