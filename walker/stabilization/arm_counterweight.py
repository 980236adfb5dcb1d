"""The arm on the side of the swing foot goes out while the robot tips over its stance foot.

It turns in the sense in which the robot falls, so the rest of the robot turns back; and its mass, farther from
the edge on which the robot stands, weighs against the fall. It comes back slowly.
"""

from __future__ import annotations

from typing import Final

import msgspec

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.types import NotNegative, Positive, Side
from walker.planning.plan import OTHER_SIDE, SIGN, Support

_SIDES: Final[tuple[Side, Side]] = ("L", "R")


class ArmCounterweightParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the arm goes out, how far and how fast."""

    deviation: Positive = 0.05
    """`Feedback.tipping` from which on it goes out, m."""
    gain: NotNegative = 15.0
    """Angle over what exceeds that bound, rad/m."""
    max_angle: NotNegative = 1.15
    """Largest angle beside the arm's angle in a walk, rad."""
    max_rate: Positive = 5.0
    """Fastest way out, rad/s: what the drives follow."""
    return_rate: Positive = 1.0
    """Fastest way back, rad/s: a fast one throws the robot again."""


class ArmCounterweight:
    """Moves ShoulderRoll.

    Args:
        parameters: bound, gain and rates.
        body: data sheet.
    """

    def __init__(self, parameters: ArmCounterweightParameters, body: Body) -> None:
        self._p = parameters
        self._joints = {side: body.joints[f"{side}ShoulderRoll"] for side in _SIDES}
        self._out = dict.fromkeys(_SIDES, 0.0)
        """Angles beside those of a walk, outward positive, rad."""

    def update(self, angles: list[float], support: Support, tipping: float, dt: float) -> None:
        """One cycle: add to the angles of both ShoulderRolls, in place.

        Args:
            angles: of the joints, 25 slots, rad.
            support: the leg that bears the weight.
            tipping: `Feedback.tipping`, m.
            dt: time since the last cycle, s.
        """
        p = self._p
        wished = min(p.gain * max(tipping - p.deviation, 0.0), p.max_angle)
        for side in _SIDES:
            goal = wished if support == OTHER_SIDE[side] else 0.0
            now = self._out[side]
            self._out[side] = min(max(goal, now - p.return_rate * dt), now + p.max_rate * dt)
            if self._out[side]:
                slot, joint = INDEX[f"{side}ShoulderRoll"], self._joints[side]
                angle = angles[slot] + SIGN[side] * self._out[side]
                angles[slot] = min(max(angle, joint.lower), joint.upper)
