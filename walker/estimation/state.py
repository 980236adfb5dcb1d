"""The measured state of the robot: the one output of its estimator, and the one input of all that reads it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from bridge.body.kinematics import RobotPose
from bridge.planar import Pose2D
from bridge.types import Array, Side, Vec2, Vec3
from walker.functions import capture_point


class OverSoles(NamedTuple):
    """The centre of mass over the middle of soles: x along the mean of their headings, y to the left."""

    place: Vec2
    """m"""
    velocity: Vec2
    """m/s, over soles that are at rest."""
    heading: float
    """Mean heading of the soles, from the torso's, rad."""

    def capture_point(self, omega: float) -> Vec2:
        """Place of a foot on which the robot comes to rest, in the same axes, m.

        Args:
            omega: frequency of the linear inverted pendulum, 1/s.
        """
        return capture_point(self.place, self.velocity, omega)


class ComState(NamedTuple):
    """Centre of mass and soles in level axes: z up by the lean, heading and origin of the torso."""

    position: Array
    """Centre of mass, shape (3,), m."""
    soles: Mapping[Side, Array]
    """Middle of each sole, shape (3,), m."""
    headings: Mapping[Side, float]
    """Heading of each sole, rad."""
    velocity: Mapping[Side, Array]
    """Velocity of the centre of mass over each sole that is at rest, shape (3,), m/s."""

    def over(self, *sides: Side) -> OverSoles:
        """The centre of mass over one sole, or over the middle of both.

        Args:
            sides: of the soles.
        """
        heading = sum(self.headings[side] for side in sides) / len(sides)
        axes, zero = Pose2D(yaw=heading), np.zeros(3)
        x, y, _ = (sum((self.position - self.soles[side] for side in sides), zero) / len(sides)).tolist()
        v_x, v_y, _ = (sum((self.velocity[side] for side in sides), zero) / len(sides)).tolist()
        return OverSoles(axes.local(x, y), axes.local(v_x, v_y), heading)


class BaseState(NamedTuple):
    """State of the robot when its sensors were read, SI units and rad.

    The odometry's frame has z up; its origin is the middle of the soles at the first frame.
    """

    pose: RobotPose
    """All links, feet and centre of mass in the odometry's frame."""
    com: ComState
    """Centre of mass over the soles, and its velocity."""
    middle: Pose2D = Pose2D()
    """Middle of both soles and mean of their headings in the odometry's frame."""
    angle: Vec2 = (0.0, 0.0)
    """Roll and pitch of the torso without drift; follows a disturbance late."""
    lean: Vec2 = (0.0, 0.0)
    """The same without lag."""
    lean_ahead: Vec2 = (0.0, 0.0)
    """`lean` less its slow mean, one latency later."""
    velocity: Array = np.zeros(3)
    """Velocity of the torso's origin in the odometry's frame, shape (3,)."""
    angular_velocity: Vec3 = (0.0, 0.0, 0.0)
    """Angular velocity of the torso, in the Torso frame."""
