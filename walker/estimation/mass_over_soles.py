"""The centre of mass over the soles that bear it, by the encoders, the lean and the gyroscope."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bridge.body.kinematics import FloatingBase, RobotPose
from bridge.rotations import R_yaw, heading, rotation
from bridge.types import Array, Side, Vec2, Vec3


class MassOverSoles:
    """Follows the centre of mass over the middle of soles, once per received frame.

    Args:
        base: kinematics of the body.
        smoothing: time constant of the velocity by the joints' motion, s; the gyroscope gives that by the turn.
    """

    def __init__(self, base: FloatingBase, smoothing: float) -> None:
        self._base, self._smoothing = base, smoothing
        self._sides: tuple[Side, ...] = ()
        self._offset: Array = np.zeros(3)
        self._rate: Array = np.zeros(3)

    def update(
        self, pose: RobotPose, sides: Sequence[Side], lean: Vec2, gyroscope: Vec3, dt: float
    ) -> tuple[Array, Array, Array]:
        """One cycle.

        Args:
            pose: of the robot in the Torso frame.
            sides: of the soles.
            lean: roll and pitch of the torso, rad.
            gyroscope: angular velocity in the Torso frame, rad/s.
            dt: time since the last cycle, s.

        Returns:
            Place over the middle of the soles and velocity, x ahead and y to the left of them, m and m/s; the
            rotation from the Torso frame.
        """
        centres = self._base.centres
        ways = (pose.com - (pose.feet[side] @ centres[side])[:3] for side in sides)
        offset: Array = sum(ways, np.zeros(3)) / len(sides)
        if tuple(sides) == self._sides and dt > 0.0:
            share = min(dt / self._smoothing, 1.0)
            self._rate = self._rate + share * ((offset - self._offset) / dt - self._rate)
        self._offset, self._sides = offset, tuple(sides)
        level = rotation(*lean, 0.0)
        yaw = sum(heading(level @ pose.feet[side][:3, :3]) for side in sides) / len(sides)
        turn = R_yaw(-yaw) @ level
        (w_x, w_y, w_z), (x, y, z) = gyroscope, offset.tolist()
        turning = w_y * z - w_z * y, w_z * x - w_x * z, w_x * y - w_y * x
        return (turn @ offset)[:2], (turn @ (turning + self._rate))[:2], turn

    def reset(self) -> None:
        """Let the next velocity begin with the joints' last."""
        self._sides = ()
