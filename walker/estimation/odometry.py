"""Odometry: pose of the robot in the world by forward kinematics, the fused angle and the foot that stands.

No sensor of a NAO measures position. The foot with the larger load is taken to stand still, and the motion of
the other links follows from it. Slip and bent joints are not seen. A gyroscope with a vertical axis sees a foot
that spins; without one the foot is taken to keep its heading, too.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from bridge.body.kinematics import FloatingBase, RobotPose, Transform, homogeneous
from bridge.messages import SensorFrame
from bridge.rotations import R_yaw, heading, rotation
from bridge.types import SIDES, Array, Side
from walker.estimation.heading import GyroscopeHeading
from walker.planning.plan import Foothold

SWITCH: Final = 0.6
"""Fraction of the weight at which a foot becomes the one that stands; over a half against chatter."""


class GroundPlane(NamedTuple):
    """A tilted plane through a point under which the world's origin lies."""

    roll: float = 0.0
    """rad; the orientation is Ry(pitch) Rx(roll)."""
    pitch: float = 0.0
    """rad"""
    height: float = 0.0
    """Of the plane at the world's origin, m."""

    @property
    def normal(self) -> Array:
        """Unit vector, shape (3,)."""
        return rotation(self.roll, self.pitch, 0.0)[:, 2]

    def at(self, x: float, y: float) -> float:
        """Height of the plane, m.

        Args:
            x: in the world, m.
            y: in the world, m.
        """
        n = self.normal
        return self.height - float(n[0] * x + n[1] * y) / float(n[2])


LEVEL: Final = GroundPlane()


class Odometry:
    """Places the robot frame by frame by its sensors alone.

    Args:
        robot: Kinematics of the body.
        start: Where the middle of the soles is at the first frame.
        gyroscope: Tells the torso's heading; None: the standing foot does.
    """

    def __init__(
        self,
        robot: FloatingBase,
        start: Foothold = Foothold(),  # noqa: B008 (frozen)
        gyroscope: GyroscopeHeading | None = None,
    ) -> None:
        self._robot, self._gyroscope = robot, gyroscope
        self._start: Foothold | None = start
        self.stance: Side = "L"
        """The foot that is taken to stand."""
        self._at = Foothold()
        self._initial_heading = 0.0
        """The torso's heading at the first frame, rad."""

    def update(self, frame: SensorFrame, ground: GroundPlane = LEVEL) -> RobotPose:
        """One frame; the lowest corner of the standing sole is put on the ground.

        Args:
            frame: newest sensor frame.
            ground: in the world.
        """
        in_torso = self._robot.in_torso(frame.position)
        tilt = homogeneous(rotation(*frame.angle, 0.0), (0.0, 0.0, 0.0))
        foot = self._robot.foot(in_torso, self.stance)
        sole = self._of_sole(tilt @ foot)
        if self._start is not None:
            torso = _carried(middle_of_soles(self._robot, self._robot.place(in_torso, tilt)), self._start)
            self._start = None
            self._at = self._of_sole(torso @ tilt @ foot)
            self._initial_heading = self._at.yaw - sole.yaw
        if self._gyroscope is not None:
            self._at = self._at._replace(yaw=sole.yaw + self._initial_heading + self._gyroscope.update(frame))
        # The standing sole keeps its place, and its heading unless the gyroscope says otherwise.
        torso = _carried(sole, self._at) @ tilt
        torso[2, 3] += self._over_ground(torso @ foot, ground)
        pose = self._robot.place(in_torso, torso)
        left, right = sum(frame.fsr[:4]), sum(frame.fsr[4:])
        heavier: Side = "L" if left > right else "R"
        if heavier != self.stance and max(left, right) > SWITCH * (left + right):
            self.stance = heavier
            self._at = self._of_sole(pose.feet[self.stance])
        return pose

    def _of_sole(self, foot: Transform) -> Foothold:
        x, y = (foot @ self._robot.centres[self.stance])[:2]
        return Foothold(float(x), float(y), heading(foot))

    def _over_ground(self, foot: Transform, ground: GroundPlane) -> float:
        """Way up that puts the lowest corner of the standing sole on the ground, m."""
        corners, n = self._robot.sole_in_world(self.stance, foot), ground.normal
        return ground.height - float(np.min(corners @ n)) / float(n[2])


def middle_of_soles(robot: FloatingBase, pose: RobotPose) -> Foothold:
    """Middle between both soles, and the mean of their headings.

    Args:
        robot: Kinematics of the body.
        pose: in the frame of the result.
    """
    left, right = (pose.feet[side] for side in SIDES)
    x, y = (0.5 * (left @ robot.centres["L"] + right @ robot.centres["R"])[:2]).tolist()
    ahead, aside = (left[:2, 0] + right[:2, 0]).tolist()
    return Foothold(x, y, math.atan2(aside, ahead))


def on_ground(at: Foothold) -> Transform:
    """Transform of a frame with z up whose origin and heading are those of a foothold, shape (4, 4), m."""
    return homogeneous(R_yaw(at.yaw), (at.x, at.y, 0.0))


def _carried(here: Foothold, there: Foothold) -> Transform:
    """Transform on the ground that carries one foothold to another."""
    x, y = Foothold(yaw=there.yaw - here.yaw).point(here.x, here.y)
    return on_ground(Foothold(there.x - x, there.y - y, there.yaw - here.yaw))
