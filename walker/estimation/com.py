"""Centre of mass over the soles, by encoders, lean and gyroscope."""

from __future__ import annotations

from collections.abc import Sequence

from bridge.body.kinematics import FloatingBase, homogeneous
from bridge.rotations import heading, rotation
from bridge.types import SIDES, Array, Side, Vec2, Vec3
from walker.estimation.state import ComState
from walker.functions import SmoothedRate


class ComEstimator:
    """Follows the centre of mass over each sole, once per received frame.

    The velocity over a sole at rest has two parts: the motion of the joints, which is the smoothed difference
    of the encoders, and the turn of the robot as a whole about that sole, which is the gyroscope's.

    Args:
        base: kinematics of the body.
        smoothing: time constant of the first part, s.
    """

    def __init__(self, base: FloatingBase, smoothing: float) -> None:
        self._base = base
        self._rates = {side: SmoothedRate(smoothing) for side in SIDES}

    def update(self, position: Sequence[float], lean: Vec2, gyroscope: Vec3, dt: float) -> ComState:
        """One cycle.

        Args:
            position: joint angles, 25 slots, rad.
            lean: roll and pitch of the torso, rad.
            gyroscope: angular velocity in the Torso frame, rad/s.
            dt: time since the last cycle, s.
        """
        tilt = rotation(*lean, 0.0)
        level = self._base.place(self._base.in_torso(position), homogeneous(tilt, (0.0, 0.0, 0.0)))
        soles = {side: (level.feet[side] @ self._base.centres[side])[:3] for side in SIDES}
        w_x, w_y, w_z = gyroscope
        velocity: dict[Side, Array] = {}
        for side in SIDES:
            offset = (level.com - soles[side]) @ tilt  # in the Torso frame
            x, y, z = offset.tolist()
            turning = w_y * z - w_z * y, w_z * x - w_x * z, w_x * y - w_y * x
            velocity[side] = tilt @ (turning + self._rates[side].update(offset, dt))
        return ComState(level.com, soles, {side: heading(level.feet[side]) for side in SIDES}, velocity)
