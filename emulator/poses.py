"""Poses: a position and an orientation of one frame in another.

Composition rounds to single precision (1e-8 m), operation by operation, as PyBullet's programming interface
does: the placed poses, and with them all recorded runs, stay the same bit for bit. Known weakness: an engine
that computes in double precision is given poses with that error.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.types import Quaternion, Vec3
from emulator.compiled import compilable
from emulator.vectors import Rotation

_Real: Final = np.float32
Basis = NDArray[np.float32]


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
    a, b = _basis(outer.orientation), _basis(inner.orientation)
    turned = a[:, :1] * b[0] + a[:, 1:2] * b[1] + a[:, 2:] * b[2]
    return Pose(point_of(outer, inner.position), _quaternion(turned))


def point_of(pose: Pose, place: Vec3) -> Vec3:
    """A place (m) of frame B in A.

    Args:
        pose: B in A.
        place: In B.
    """
    if pose is ORIGIN:
        x, y, z = np.array(place, dtype=_Real).tolist()
    else:
        a, (x, y, z) = _basis(pose.orientation), np.array(place, dtype=_Real)
        x, y, z = (a[:, 0] * x + a[:, 1] * y + a[:, 2] * z + np.array(pose.position, dtype=_Real)).tolist()
    return x, y, z


def inverse(pose: Pose) -> Pose:
    """The pose of A in B from that of B in A."""
    if pose is ORIGIN:
        return ORIGIN
    back = _basis(pose.orientation).T
    x, y, z = -np.array(pose.position, dtype=_Real)
    x, y, z = (back[:, 0] * x + back[:, 1] * y + back[:, 2] * z).tolist()
    return Pose((x, y, z), _quaternion(back))


def quaternion(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Quaternion:
    """The quaternion of Rz(yaw) Ry(pitch) Rx(roll), angles in rad."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a / 2.0), math.cos(a / 2.0)) for a in (roll, pitch, yaw))
    x, y = sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy
    z, w = cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm


@compilable
def matrix(q: Quaternion) -> Rotation:
    """Rotation matrix of a quaternion, row by row, in double precision."""
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


def _basis(q: Quaternion) -> Basis:
    """Rotation matrix in single precision, (3, 3)."""
    x, y, z, w = (_Real(part) for part in q)
    one, s = _Real(1.0), _Real(2.0) / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * s, y * s, z * s
    rows = (
        (one - (y * ys + z * zs), x * ys - w * zs, x * zs + w * ys),
        (x * ys + w * zs, one - (x * xs + z * zs), y * zs - w * xs),
        (x * zs - w * ys, y * zs + w * xs, one - (x * xs + y * ys)),
    )
    return np.array(rows, dtype=_Real)


def _quaternion(m: Basis) -> Quaternion:
    """The quaternion of a rotation matrix (3, 3)."""
    half, one, q = _Real(0.5), _Real(1.0), [_Real(0.0)] * 4
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    # Divide by the largest component of the quaternion: w, or that of the largest diagonal element.
    if trace > 0.0:
        root = np.sqrt(trace + one)
        q[3], root = root * half, half / root
        q[0], q[1], q[2] = (m[2, 1] - m[1, 2]) * root, (m[0, 2] - m[2, 0]) * root, (m[1, 0] - m[0, 1]) * root
    else:
        i = int(np.argmax(np.diag(m)))
        j, k = (i + 1) % 3, (i + 2) % 3
        root = np.sqrt(m[i, i] - m[j, j] - m[k, k] + one)
        q[i], root = root * half, half / root
        q[3], q[j], q[k] = (m[k, j] - m[j, k]) * root, (m[j, i] + m[i, j]) * root, (m[k, i] + m[i, k]) * root
    return float(q[0]), float(q[1]), float(q[2]), float(q[3])
