"""The capture point of a robot that stands, or steps out of a push: no plan says where it should be.

The encoders and the torso's lean place the centre of mass over the soles. A robot that tips over the edge of a
sole turns about it as a whole, so nothing but the lean shows it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np

from bridge.body.kinematics import FloatingBase
from bridge.body.quantities import GRAVITY, total_mass
from bridge.body.sole import sole_hull
from bridge.types import SIDES, NotNegative, Positive, Vec2, Vec3
from walker.estimation.mass_over_soles import MassOverSoles
from walker.planning.feedback import CaptureStep
from walker.planning.plan import Plan

_STANDING_LOAD: Final = 0.3
"""Part of the weight under both feet from which on the robot stands on the ground (assumed).

Less than one cell reads at most, 25 N (range of the data sheet): a robot may be on the corner of one sole.
"""


class CaptureParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the capture point is filtered and predicted."""

    latency: NotNegative = 0.04
    """From a command to the motion that the encoders report, s; the capture point is predicted over it."""
    smoothing: Positive = 0.03
    """As in `MassOverSoles`, s."""
    min_time_after_step: NotNegative = 0.1
    """Time after a step of the walk in which no capture step begins, s. The encoders report a foot a latency
    late: while it still swings ahead, the centre of mass seems to go back between the soles."""


class CaptureEstimator:
    """Follows the centre of mass over the soles, and says when toes or heels do not hold it.

    Args:
        parameters: of filter and prediction.
        base: kinematics of the body.
    """

    def __init__(self, parameters: CaptureParameters, base: FloatingBase) -> None:
        self._p = parameters
        self._base = base
        self._mass = MassOverSoles(base, parameters.smoothing)
        x, _ = sole_hull(base.body, "L").T
        self._heel, self._toe = float(x.min()), float(x.max())
        self._weight = GRAVITY * total_mass(base.body)
        self._lost = False
        self._since_step = math.inf
        """Time since the last step by the plan, s."""

    def update(
        self,
        position: Sequence[float],
        lean: Vec2,
        gyroscope: Vec3,
        load: float,
        plan: Plan,
        dt: float,
    ) -> CaptureStep | None:
        """One cycle.

        Args:
            position: joint angles, 25 slots, rad.
            lean: roll and pitch of the torso, rad.
            gyroscope: angular velocity in the Torso frame, rad/s.
            load: on both feet, N.
            plan: in force.
            dt: time since the last cycle, s.

        Returns:
            Centre of mass and capture point when this cycle's command is carried out, in the walk frame, while
            the robot makes a capture step; None: it stands, or walks.
        """
        rests = plan.phase in ("stand", "stop")
        self._since_step = self._since_step + dt if plan.support == "both" else 0.0
        if plan.pendulum is None or not (rests or self._lost):
            self._mass.reset()
            return None
        sides = SIDES if plan.support == "both" else (plan.support,)
        pose = self._base.place(self._base.in_torso(position), np.eye(4))
        over, rate, _ = self._mass.update(pose, sides, lean, gyroscope, dt)
        com = over + np.mean([self._base.centres[side][:2] for side in sides], axis=0)
        base = plan.middle if plan.support == "both" else plan.foot(plan.support).foothold
        ahead = [base.local(*plan.foot(side)[:2])[0] for side in sides]
        heel, toe = self._heel + min(ahead), self._toe + max(ahead)
        omega = plan.pendulum.omega
        x, y = (com + rate / omega).tolist()
        edge = min(max(x, heel), toe)
        if rests:
            landed = plan.capture is not None or self._since_step > self._p.min_time_after_step
            self._lost = landed and x != edge and load > _STANDING_LOAD * self._weight
        if not self._lost:
            return None
        x = edge + (x - edge) * math.exp(omega * self._p.latency)
        c_x, c_y = (com + self._p.latency * rate).tolist()
        return CaptureStep(base.point(c_x, c_y), base.point(x, y))
