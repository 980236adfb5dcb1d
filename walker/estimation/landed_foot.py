"""The centre of mass beside the ankle of the foot that landed from a capture step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bridge.body.kinematics import FloatingBase
from bridge.types import Vec2, Vec3
from walker.estimation.capture import CaptureParameters
from walker.estimation.mass_over_soles import MassOverSoles
from walker.planning.feedback import LandedFoot
from walker.planning.plan import Plan


class LandedFootEstimator:
    """Follows the centre of mass over the foot that landed, by encoders, lean and gyroscope.

    Args:
        parameters: of filter and prediction.
        base: kinematics of the body.
    """

    def __init__(self, parameters: CaptureParameters, base: FloatingBase) -> None:
        self._p = parameters
        self._base = base
        self._mass = MassOverSoles(base, parameters.smoothing)

    def update(
        self, position: Sequence[float], lean: Vec2, gyroscope: Vec3, plan: Plan, dt: float
    ) -> LandedFoot | None:
        """One cycle.

        Args:
            position: joint angles, 25 slots, rad.
            lean: roll and pitch of the torso, rad.
            gyroscope: angular velocity in the Torso frame, rad/s.
            plan: in force.
            dt: time since the last cycle, s.

        Returns:
            From the landing of a capture step until the feet close, else None.
        """
        if plan.capture is None or plan.support != "both" or plan.pendulum is None:
            self._mass.reset()
            return None
        pose = self._base.place(self._base.in_torso(position), np.eye(4))
        over, rate, _ = self._mass.update(pose, (plan.capture,), lean, gyroscope, dt)
        y = float(over[1] + self._base.centres[plan.capture][1])
        xi = y + float(rate[1]) / plan.pendulum.omega
        return LandedFoot(xi, lean[0] + self._p.latency * gyroscope[0])
