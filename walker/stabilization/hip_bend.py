"""Bend of the hips in a capture step back, which lets the foot reach farther; not in the thesis.

A robot that tips over its heels leans back as a whole. Its HipPitch then comes to its stop (27.7 degrees,
data sheet) while the foot that steps is still ahead of where the capture point asks for it. Where both hips
bend by one angle, the torso turns ahead by it, and the legs stay as they are: the stop is as much farther away.

The bend must begin with the step. It goes back where the capture point shows within the first cycles that the
push is weak or goes to a side.
"""

from __future__ import annotations

import msgspec

from bridge.body import Body
from bridge.types import NotNegative, Positive
from walker.functions import clip
from walker.planning.feedback import CaptureStep
from walker.planning.plan import Plan


class HipBendParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How far, how fast and for which pushes the hips bend."""

    angle: NotNegative = 0.35
    """Of the torso against the legs, rad."""
    rate: Positive = 4.0
    """Of the bend, rad/s: HipPitch turns at 7 rad/s at most (no-load speed)."""
    return_rate: Positive = 2.0
    """Of the way back, rad/s: as the leg that landed rights the torso."""
    min_behind: NotNegative = 0.081
    """Capture point behind the stance ankle beyond which the bend goes on, m."""
    decision: NotNegative = 0.15
    """Fraction of the step at which the capture point must have been that far behind."""
    max_beside: NotNegative = 0.02
    """Capture point beside the middle between the feet beyond which the hips stay as they are, m."""


class HipBend:
    """Bends both hips in a capture step straight back.

    Args:
        parameters: how far and when.
        body: data sheet.
    """

    def __init__(self, parameters: HipBendParameters, body: Body) -> None:
        self._p = parameters
        self._half_width = body.lengths.HipOffsetY
        self._angle = 0.0
        self._behind = self._beside = 0.0
        """Farthest places of the capture point before the decision, m."""

    def update(self, plan: Plan, measured: CaptureStep | None, dt: float) -> float:
        """One cycle.

        Args:
            plan: in force.
            measured: centre of mass and capture point in the walk frame.
            dt: time since the last cycle, s.

        Returns:
            Angle by which the torso is turned ahead against the legs, rad.
        """
        p, goal, rate = self._p, 0.0, self._p.return_rate
        if plan.captures_backward and plan.support != "both":
            rate = p.rate
            undecided = plan.progress <= p.decision
            if undecided and measured is not None:
                x, y = plan.foot(plan.support).foothold.local(*measured.xi)
                self._behind = max(self._behind, -x)
                self._beside = max(self._beside, abs(abs(y) - self._half_width))
            needed = undecided or self._behind > p.min_behind
            goal = p.angle if needed and self._beside <= p.max_beside else 0.0
        else:
            self._behind = self._beside = 0.0
        self._angle += clip(goal - self._angle, -rate * dt, rate * dt)
        return self._angle
