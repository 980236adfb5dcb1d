"""Odometry: pose of the robot in the world by forward kinematics, the fused angle and the stance foot.

No sensor of a NAO measures position. The foot with the larger load is taken as fixed, and the motion of
the other links follows from it. Slip and bent joints are not seen. A gyroscope with a vertical axis sees a foot
that spins; without one the foot is taken to keep its heading, too. The gyroscope's bias is found on both feet,
where no joint but HipYawPitch turns the torso about the vertical; so also while the robot moves into its first
posture.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.body.kinematics import FloatingBase, RobotPose, Transform, homogeneous
from bridge.messages import SensorFrame
from bridge.planar import Pose2D
from bridge.rotations import R_yaw, heading, rotation
from bridge.types import SIDES, Array, Side

_MAX_REST_RATE: Final = 0.1
"""Largest rate about the vertical of a torso that does not turn, rad/s: the gyroscope's bias (three deviations
of the largest that the ensemble has), and its noise."""
_MAX_REST_TURN: Final = 0.004
"""Largest motion of HipYawPitch then, rad: three counts of its encoder."""
_MIN_LOAD_RATIO: Final = 0.2
"""Least load of the one foot over that of the other, of a robot on both."""
_MIN_REST_TIME: Final = 0.2
"""s of rest before the bias is believed."""
_MEAN_TIME: Final = 20.0
"""s over which the bias is averaged, at most."""
_SETTLING_TURN: Final = 0.002
"""Turn that a robot at rest really makes, rad: a V6 that moves into its stand."""
_OUTLIER: Final = 5.0
"""Deviations beyond which a mean at rest is the bias of a gyroscope that the data sheet does not describe."""
_HIP_YAW: Final = INDEX["LHipYawPitch"]


class GyroscopeHeading:
    """Sums up the yaw rate; the robot rests while it is on both feet, or none, and nothing turns it.

    Args:
        body: must have a gyroscope of three axes.
    """

    def __init__(self, body: Body) -> None:
        assert body.inertial_unit.gyroscope_axes == 3
        self._spread = body.inertial_unit.gyroscope_bias
        self._bias = self._heading = self._rest_time = self._hip_yaw = 0.0
        self._mean = self._mean_time = 0.0
        """Rate at rest, rad/s, and the time over which it is averaged, s."""
        self._last: SensorFrame | None = None

    @staticmethod
    def of(body: Body) -> GyroscopeHeading | None:
        """Heading estimator of a body whose gyroscope has a vertical axis; None: it has none."""
        return GyroscopeHeading(body) if body.inertial_unit.gyroscope_axes == 3 else None

    def update(self, frame: SensorFrame) -> float:
        """Heading since the first frame, rad.

        Args:
            frame: newest sensor frame.
        """
        last, self._last = self._last, frame
        if last is None:
            return self._heading
        dt = frame.time - last.time
        roll, pitch = frame.angle
        _, q, r = frame.gyroscope
        rate = (math.sin(roll) * q + math.cos(roll) * r) / math.cos(pitch)
        self._update_bias(frame, rate, dt)
        self._heading += (rate - self._bias) * dt
        return self._heading

    def _update_bias(self, frame: SensorFrame, rate: float, dt: float) -> None:
        hip_yaw, loads = frame.position[_HIP_YAW], (sum(frame.fsr[:4]), sum(frame.fsr[4:]))
        turns = abs(hip_yaw - self._hip_yaw) > _MAX_REST_TURN or abs(rate) > _MAX_REST_RATE
        if turns or min(loads) < _MIN_LOAD_RATIO * max(loads):
            self._rest_time, self._hip_yaw = 0.0, hip_yaw
            return
        self._rest_time += dt
        if self._rest_time > _MIN_REST_TIME:
            self._mean_time = min(self._mean_time + dt, _MEAN_TIME)
            self._mean += dt / self._mean_time * (rate - self._mean)
            # Less of a short rest counts: its settling would outweigh the bias of a calibrated gyroscope.
            expected, error = self._spread**2, (_SETTLING_TURN / self._mean_time) ** 2
            described = self._mean**2 < _OUTLIER**2 * (expected + error)
            self._bias = self._mean * (expected / (expected + error) if described else 1.0)


STANCE_LOAD: Final = 0.6
"""Fraction of the weight at which a foot becomes the stance foot; over a half against chatter."""


class GroundPlane(NamedTuple):
    """A tilted plane through a point below the world's origin."""

    roll: float = 0.0
    """rad; the orientation is Ry(pitch) Rx(roll)."""
    pitch: float = 0.0
    """Pitch of the plane, rad."""
    height: float = 0.0
    """Height of the plane at the world's origin, m."""

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
        gyroscope: Gives the torso's heading; None: the stance foot does.
    """

    def __init__(
        self,
        robot: FloatingBase,
        start: Pose2D = Pose2D(),  # noqa: B008 (frozen)
        gyroscope: GyroscopeHeading | None = None,
    ) -> None:
        self._robot, self._gyroscope = robot, gyroscope
        self._start: Pose2D | None = start
        self.stance: Side = "L"
        """Foot that is taken as fixed."""
        self._stance_pose = Pose2D()
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
        sole = self._sole_pose(tilt @ foot)
        if self._start is not None:
            torso = _transform(middle_of_soles(self._robot, self._robot.place(in_torso, tilt)), self._start)
            self._start = None
            self._stance_pose = self._sole_pose(torso @ tilt @ foot)
            self._initial_heading = self._stance_pose.yaw - sole.yaw
        if self._gyroscope is not None:
            yaw = sole.yaw + self._initial_heading + self._gyroscope.update(frame)
            self._stance_pose = self._stance_pose._replace(yaw=yaw)
        # The stance sole keeps its place, and its heading where there is no gyroscope.
        torso = _transform(sole, self._stance_pose) @ tilt
        torso[2, 3] += self._height_correction(torso @ foot, ground)
        pose = self._robot.place(in_torso, torso)
        left, right = sum(frame.fsr[:4]), sum(frame.fsr[4:])
        heavier: Side = "L" if left > right else "R"
        if heavier != self.stance and max(left, right) > STANCE_LOAD * (left + right):
            self.stance = heavier
            self._stance_pose = self._sole_pose(pose.feet[self.stance])
        return pose

    def _sole_pose(self, foot: Transform) -> Pose2D:
        x, y = (foot @ self._robot.centres[self.stance])[:2]
        return Pose2D(float(x), float(y), heading(foot))

    def _height_correction(self, foot: Transform, ground: GroundPlane) -> float:
        """Way up that puts the lowest corner of the standing sole on the ground, m."""
        corners, n = self._robot.sole_in_world(self.stance, foot), ground.normal
        return ground.height - float(np.min(corners @ n)) / float(n[2])


def middle_of_soles(robot: FloatingBase, pose: RobotPose) -> Pose2D:
    """Middle between both soles, and the mean of their headings.

    Args:
        robot: Kinematics of the body.
        pose: in the frame of the result.
    """
    left, right = (pose.feet[side] for side in SIDES)
    x, y = (0.5 * (left @ robot.centres["L"] + right @ robot.centres["R"])[:2]).tolist()
    ahead, aside = (left[:2, 0] + right[:2, 0]).tolist()
    return Pose2D(x, y, math.atan2(aside, ahead))


def on_ground(at: Pose2D) -> Transform:
    """Transform of a frame with z up whose origin and heading are those of a foothold, shape (4, 4), m."""
    return homogeneous(R_yaw(at.yaw), (at.x, at.y, 0.0))


def _transform(here: Pose2D, there: Pose2D) -> Transform:
    """Transform on the ground from one foothold to another."""
    x, y = Pose2D(yaw=there.yaw - here.yaw).point(here.x, here.y)
    return on_ground(Pose2D(there.x - x, there.y - y, there.yaw - here.yaw))
