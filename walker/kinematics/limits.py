"""Which joint limits a set of leg angles breaks, and by how much."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

from bridge.datasheet.model import Body, Side
from bridge.datasheet.quantities import coupled_limits
from bridge.joints import LEG_JOINTS

_ANKLE_PITCH: Final = 4
"""Place of AnklePitch, to which AnkleRoll's range is coupled, among a leg's six angles."""


class LimitViolation(NamedTuple):
    """One joint outside its range."""

    joint: str
    excess: float
    """Above the upper limit (positive) or below the lower one (negative), rad."""


def limit_violations(body: Body, side: Side, angles: Sequence[float]) -> tuple[LimitViolation, ...]:
    """The joints of a leg that stand outside their ranges, in chain order; AnkleRoll's depends on AnklePitch.

    Args:
        body: The data sheet.
        side: The leg.
        angles: HipYawPitch, HipRoll, HipPitch, KneePitch, AnklePitch, AnkleRoll, rad.
    """
    found = []
    for joint, angle in zip(LEG_JOINTS[side], angles, strict=True):
        lower, upper = coupled_limits(body, joint, angles[_ANKLE_PITCH])
        excess = max(angle - upper, 0.0) + min(angle - lower, 0.0)
        if excess != 0.0:
            found.append(LimitViolation(joint, excess))
    return tuple(found)
