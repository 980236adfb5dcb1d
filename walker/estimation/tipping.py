"""A robot that tips over the outer edge of its stance foot, and what brings it back.

A push towards the stance foot moves the capture point to the outside of that foot, where the swing foot cannot
follow: the legs would cross. So does a push towards a swing foot that lands before it could go wider. The stiff
leg then stands on its outer edge, where the ZMP is as far outside as it can be, and a robot that is slow enough
comes back. Until then

- the support does not change: the other foot is in the air;
- the swing foot goes out to its own side: its mass moves the centre of mass there, and the angular momentum of
  the leg is that of the fall;
- so does the arm on that side (`walker.stabilization.arm_counterweight`).

A robot that tips ahead or back at the same time must step there. So a part of the deviation along the foot
counts against both counterweights.
"""

from __future__ import annotations

from typing import Final

import msgspec

from bridge.types import NotNegative, Positive
from walker.planning.feedback import Feedback
from walker.planning.plan import SIGN, Foothold, Plan

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
        """One cycle: the feedback with `hold`, `tipping` and `counterweight`.

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
        return feedback._replace(hold=hold, tipping=tipping, counterweight=self._out)

    def _is_to_hold(self, outward: float, progress: float, dt: float) -> bool:
        if progress < 1.0:
            self._held = 0.0
        hold = outward > 0.0 and self._held < self._p.max_hold
        if not self._held:
            hold = progress > _LATE and outward > self._p.hold_deviation
        if hold and progress >= 1.0:
            self._held += dt
        return hold
