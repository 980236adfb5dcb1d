"""A robot that tips over the outer edge of its stance foot: longer steps; not in the thesis.

Reads: deviation of the capture point (`Feedback.deviation`), plan. Gives: `Feedback.extend_step` for the gait.

A push towards the stance foot moves the capture point to the outside of that foot, where the swing foot cannot
follow: the legs would cross. So does a push towards a swing foot that lands before it could step wider. The
stiff leg is then on its outer edge, where the ZMP is as far outside as it can be, and a slow enough robot
returns. Until then the support does not change: the other foot is in the air.
"""

from __future__ import annotations

from typing import Final

import msgspec

from bridge.planar import Pose2D
from bridge.types import NotNegative, Positive
from walker.gaits.plan import SIGN, Feedback, Plan

_EARLIEST_HOLD: Final = 0.8
"""Part of a step after which a hold may begin."""


class TippingParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Threshold of tipping, and duration of the hold of a step."""

    hold_deviation: Positive = 0.08
    """Deviation of the capture point to the outside of the stance foot from which on a step is held, m.

    Late in a step: 0.05 to 0.08 with a sole askew on a plate of 10 mm, 0.11 and more with a robot on the
    edge of its foot.
    """
    max_hold: NotNegative = 1.0
    """Longest time by which a step is prolonged, s."""


class TippingDetector:
    """Watches the deviation of the capture point to the outside of the stance foot.

    Args:
        parameters: bounds.
    """

    def __init__(self, parameters: TippingParameters) -> None:
        self._p = parameters
        self._hold_time = 0.0
        """Time by which the step under way has been prolonged, s."""

    def update(self, feedback: Feedback, plan: Plan, dt: float) -> Feedback:
        """One cycle: the feedback with `extend_step`.

        Args:
            feedback: with the deviation, in the walk frame.
            plan: in force.
            dt: time since the last cycle, s.
        """
        if plan.support == "both":
            self._hold_time = 0.0
            return feedback
        _, across = Pose2D(yaw=-plan.foot(plan.support).yaw).point(*feedback.deviation)
        hold = self._holds(SIGN[plan.support] * across, plan.progress, dt)
        return feedback._replace(extend_step=hold)

    def _holds(self, outward: float, progress: float, dt: float) -> bool:
        if progress < 1.0:
            self._hold_time = 0.0
        hold = outward > 0.0 and self._hold_time < self._p.max_hold
        if not self._hold_time:
            hold = progress > _EARLIEST_HOLD and outward > self._p.hold_deviation
        if hold and progress >= 1.0:
            self._hold_time += dt
        return hold
