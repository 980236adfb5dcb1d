"""Arms as counterweights of a robot that falls: they turn in the sense of the fall, so the rest turns back.

While the robot tips over its stance foot, the arm on the side of the swing foot goes out; its mass, farther
from the edge on which the robot stands, weighs against the fall, too. In a capture step back both arms swing
ahead and up. They come back slowly.
"""

from __future__ import annotations

import msgspec

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.types import SIDES, NotNegative, Positive
from walker.planning.plan import OTHER_SIDE, SIGN, Plan, Support


class ArmCounterweightParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the arms go out or up, how far and how fast."""

    deviation: Positive = 0.05
    """`Feedback.tipping` from which on an arm goes out, m."""
    gain: NotNegative = 15.0
    """Angle over what exceeds that bound, rad/m."""
    max_angle: NotNegative = 1.15
    """Largest angle beside the arm's angle in a walk, rad."""
    max_rate: Positive = 5.0
    """Fastest way out, rad/s: what the drives follow."""
    backward_angle: NotNegative = 3.4
    """Of both arms in a capture step back, rad: from hanging beyond straight up."""
    backward_rate: Positive = 8.8
    """Of that, rad/s: over ShoulderPitch's no-load speed, 7.9 to 8.3 rad/s, so it goes as fast as it can."""
    return_rate: Positive = 1.0
    """Fastest way back, rad/s: a fast one throws the robot again."""


class ArmCounterweight:
    """Moves ShoulderRoll and ShoulderPitch.

    Args:
        parameters: bound, gain and rates.
        body: data sheet.
    """

    def __init__(self, parameters: ArmCounterweightParameters, body: Body) -> None:
        self._p = parameters
        self._joints = body.joints
        self._out = dict.fromkeys(SIDES, 0.0)
        """Angles of ShoulderRoll beside those of a walk, outward positive, rad."""
        self._up = 0.0
        """The same of both ShoulderPitches, upward positive, rad."""
        self._rises = False

    def update(self, angles: list[float], plan: Plan, support: Support, tipping: float, dt: float) -> None:
        """One cycle: add to the angles of ShoulderRoll and ShoulderPitch, in place.

        Args:
            angles: of the joints, 25 slots, rad.
            plan: in force.
            support: the leg that bears the weight.
            tipping: `Feedback.tipping`, m.
            dt: time since the last cycle, s.
        """
        p = self._p
        wished = min(p.gain * max(tipping - p.deviation, 0.0), p.max_angle)
        starts = plan.captures_backward and plan.support != "both"
        self._rises = starts or (self._rises and self._up < p.backward_angle)
        rate = p.backward_rate if self._rises else -p.return_rate
        self._up = min(max(self._up + rate * dt, 0.0), p.backward_angle)
        for side in SIDES:
            goal = wished if support == OTHER_SIDE[side] else 0.0
            now = self._out[side]
            self._out[side] = min(max(goal, now - p.return_rate * dt), now + p.max_rate * dt)
            self._add(angles, f"{side}ShoulderRoll", SIGN[side] * self._out[side])
            self._add(angles, f"{side}ShoulderPitch", -self._up)

    def _add(self, angles: list[float], name: str, by: float) -> None:
        if by:
            slot, joint = INDEX[name], self._joints[name]
            angles[slot] = min(max(angles[slot] + by, joint.lower), joint.upper)
