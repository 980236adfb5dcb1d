"""Poses: a position and an orientation of one frame in another."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from bridge.types import Quaternion, Vec3
from emulator.compiled import compilable
from emulator.vectors import Rotation, add, rotate, rotate_back, scaled


class Pose(NamedTuple):
    """A frame in another one."""

    position: Vec3 = (0.0, 0.0, 0.0)
    """Origin, m."""
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    """x, y, z, w."""


ORIGIN: Final = Pose()


def compose(outer: Pose, inner: Pose) -> Pose:
    """The pose of a frame C in A.

    Args:
        outer: B in A.
        inner: C in B.
    """
    ax, ay, az, aw = outer.orientation
    bx, by, bz, bw = inner.orientation
    turn = (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
    return Pose(point_of(outer, inner.position), turn)


def point_of(pose: Pose, place: Vec3) -> Vec3:
    """A place (m) of frame B in A.

    Args:
        pose: B in A.
        place: In B.
    """
    return add(rotate(matrix(pose.orientation), place), pose.position)


def inverse(pose: Pose) -> Pose:
    """The pose of A in B from that of B in A."""
    x, y, z, w = pose.orientation
    return Pose(rotate_back(matrix(pose.orientation), scaled(pose.position, -1.0)), (-x, -y, -z, w))


def quaternion(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Quaternion:
    """The quaternion of Rz(yaw) Ry(pitch) Rx(roll), angles in rad."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a / 2.0), math.cos(a / 2.0)) for a in (roll, pitch, yaw))
    x, y = sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy
    z, w = cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm


@compilable
def matrix(q: Quaternion) -> Rotation:
    """Rotation matrix of a quaternion, row by row."""
    x, y, z, w = q
    s = 2.0 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * s, y * s, z * s
    xx, xy, xz, yy, yz, zz = x * xs, x * ys, x * zs, y * ys, y * zs, z * zs
    wx, wy, wz = w * xs, w * ys, w * zs
    return (
        1.0 - (yy + zz),
        xy - wz,
        xz + wy,
        xy + wz,
        1.0 - (xx + zz),
        yz - wx,
        xz - wy,
        yz + wx,
        1.0 - (xx + yy),
    )


def yaw_of(q: Quaternion) -> float:
    """Angle about z of Rz(yaw) Ry(pitch) Rx(roll), rad."""
    m = matrix(q)
    return math.atan2(m[3], m[0])
