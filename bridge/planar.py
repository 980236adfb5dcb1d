"""Poses in the plane: the one place where x, y and yaw are transformed."""

from __future__ import annotations

import math
from typing import NamedTuple

from bridge.types import Vec2


class Pose2D(NamedTuple):
    """A pose on the ground, an element of SE(2): of a sole, of a robot, or of the origin of a walk."""

    x: float = 0.0
    """Place ahead, m."""
    y: float = 0.0
    """Place to the left, m."""
    yaw: float = 0.0
    """rad, positive: to the left"""

    def point(self, x: float, y: float) -> Vec2:
        """A point of this pose's frame in the frame of the pose.

        Args:
            x: in this pose's frame, m.
            y: the same.

        Returns:
            x and y, m.
        """
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return c * x - s * y + self.x, s * x + c * y + self.y

    def local(self, x: float, y: float) -> Vec2:
        """A point of the frame of this pose in this pose's frame, the inverse of `point`.

        Args:
            x: in the frame of the pose, m.
            y: the same.

        Returns:
            x and y, m.
        """
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x, y = x - self.x, y - self.y
        return c * x + s * y, c * y - s * x

    def pose(self, inner: Pose2D) -> Pose2D:
        """A pose of this pose's frame in the frame of the pose, as `point`."""
        return Pose2D(*self.point(inner.x, inner.y), self.yaw + inner.yaw)

    def local_pose(self, outer: Pose2D) -> Pose2D:
        """A pose of the frame of this pose in this pose's frame, the inverse of `pose`."""
        return Pose2D(*self.local(outer.x, outer.y), outer.yaw - self.yaw)
