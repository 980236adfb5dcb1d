"""A robot that tips over the outer edge of its stance foot: longer steps, foot and arm as counterweights.

Reads: deviation of the capture point (`Feedback.deviation`), plan, the leg that bears the weight.
Gives: `Feedback` with `extend_step`, `tipping` and `counterweight` for the gait (`TippingDetector`); angles of
the shoulders (`ArmCounterweight`).

A push towards the stance foot moves the capture point to the outside of that foot, where the swing foot cannot
follow: the legs would cross. So does a push towards a swing foot that lands before it could go wider. The stiff
leg then stands on its outer edge, where the ZMP is as far outside as it can be, and a robot that is slow enough
comes back. Until then

- the support does not change: the other foot is in the air;
- the swing foot goes out to its own side: its mass moves the centre of mass there, and the angular momentum of
  the leg is that of the fall;
- so does the arm on that side: it turns in the sense of the fall, so the rest turns back, and its mass, farther
  from the edge on which the robot stands, weighs against the fall. In a capture step back both arms swing ahead
  and up. They come back slowly.

A robot that tips ahead or back at the same time must step there. So a part of the deviation along the foot
counts against both counterweights.
"""

from __future__ import annotations

from typing import Final

import msgspec

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.types import SIDES, NotNegative, Positive
from walker.gaits.plan import OTHER_SIDE, SIGN, Feedback, Foothold, Plan, Support

_LATE: Final = 0.8
"""Part of a step after which a hold may begin."""


class TippingParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a robot tips, and how far the swing foot goes."""

    hold_deviation: Positive = 0.08
    """Deviation of the capture point to the outside of the stance foot from which on a step is held, m.

    Late in a step it was 0.05 to 0.08 with a sole askew on a plate of 10 mm, 0.11 and more with a robot on the
    edge of its foot.
    """
    max_hold: NotNegative = 1.0
    """Longest time by which a step is prolonged, s."""
    counterweight_deviation: Positive = 0.05
    """Deviation from which on the swing foot goes out, m."""
    counterweight_gain: NotNegative = 4.0
    """Way of the swing foot to its side over what the deviation exceeds that bound by."""
    counterweight_rate: Positive = 0.8
    """Fastest growth of that way, m/s: a leg that is flung out late in its swing throws the robot."""
    along: NotNegative = 0.5
    """Share of the deviation along the foot that is subtracted from it first."""


class TippingDetector:
    """Watches the deviation of the capture point to the outside of the stance foot.

    Args:
        parameters: bounds and gains.
        hold: prolong steps.
        counterweight: move the swing foot.
    """

    def __init__(self, parameters: TippingParameters, *, hold: bool, counterweight: bool) -> None:
        self._p, self._holds, self._moves = parameters, hold, counterweight
        self._held = 0.0
        """Time by which the step under way has been prolonged, s."""
        self._step, self._out = 0, 0.0
        """Its number, and the counterweight in it, m."""

    def update(self, feedback: Feedback, plan: Plan, dt: float) -> Feedback:
        """One cycle: the feedback with `extend_step`, `tipping` and `counterweight`.

        Args:
            feedback: with the deviation, in the walk frame.
            plan: in force.
            dt: time since the last cycle, s.
        """
        if plan.support == "both":
            self._held = 0.0
            return feedback
        p, sole = self._p, plan.foot(plan.support)
        along, across = Foothold(yaw=-sole.yaw).point(*feedback.deviation)
        outward = SIGN[plan.support] * across
        tipping = outward - p.along * abs(along)
        if plan.step != self._step:
            self._step, self._out = plan.step, 0.0
        if self._moves:
            excess = max(tipping - p.counterweight_deviation, 0.0)
            self._out = min(p.counterweight_gain * excess, self._out + p.counterweight_rate * dt)
        hold = self._holds and self._is_to_hold(outward, plan.progress, dt)
        return feedback._replace(extend_step=hold, tipping=tipping, counterweight=self._out)

    def _is_to_hold(self, outward: float, progress: float, dt: float) -> bool:
        if progress < 1.0:
            self._held = 0.0
        hold = outward > 0.0 and self._held < self._p.max_hold
        if not self._held:
            hold = progress > _LATE and outward > self._p.hold_deviation
        if hold and progress >= 1.0:
            self._held += dt
        return hold


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
