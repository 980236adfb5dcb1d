"""Rotations: matrices from angles and quaternions; roll, pitch, yaw and tilt of a quaternion.

`R_a_b` turns coordinates of frame b into frame a. Roll is about x, pitch about y, yaw about z, right-handed;
together they are R_yaw R_pitch R_roll (Prenner 2011, 2.4), as the robot's AngleX and AngleY are meant.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from bridge.types import Array, Matrix3, Quaternion, Vec3


def R_yaw(phi: float) -> Array:
    """Rotation about z by `phi` rad, shape (3, 3) (Prenner 2011, 2.1)."""
    c, s = math.cos(phi), math.sin(phi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def R_pitch(theta: float) -> Array:
    """Rotation about y by `theta` rad, shape (3, 3) (Prenner 2011, 2.2)."""
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def R_roll(psi: float) -> Array:
    """Rotation about x by `psi` rad, shape (3, 3) (Prenner 2011, 2.2)."""
    c, s = math.cos(psi), math.sin(psi)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rotation_rows(roll: float, pitch: float, yaw: float) -> Matrix3:
    """R_yaw R_pitch R_roll, multiplied out (Prenner 2011, 2.4).

    Args:
        roll: about x, rad.
        pitch: about y, rad.
        yaw: about z, rad.
    """
    c_r, s_r = math.cos(roll), math.sin(roll)
    c_p, s_p = math.cos(pitch), math.sin(pitch)
    c_y, s_y = math.cos(yaw), math.sin(yaw)
    return (
        (c_y * c_p, c_y * s_p * s_r - s_y * c_r, c_y * s_p * c_r + s_y * s_r),
        (s_y * c_p, s_y * s_p * s_r + c_y * c_r, s_y * s_p * c_r - c_y * s_r),
        (-s_p, c_p * s_r, c_p * c_r),
    )


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """R_yaw R_pitch R_roll, shape (3, 3); see `rotation_rows`."""
    return np.array(rotation_rows(roll, pitch, yaw))


def about_axis(axis: Vec3, angle: float) -> Array:
    """Rotation about any axis, shape (3, 3) (Rodrigues' formula).

    Args:
        axis: unit vector.
        angle: rad, right-handed.
    """
    cross = np.cross(np.eye(3), axis)
    R: Array = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return R


def heading(R: Array) -> float:
    """Yaw of a rotation matrix or a homogeneous transform, shape (3, 3) or (4, 4): of its x axis, rad."""
    return math.atan2(R[1, 0], R[0, 0])


def angles(R: Array) -> Vec3:
    """Roll, pitch and yaw of a rotation matrix or a homogeneous transform, rad; the inverse of `rotation`."""
    pitch = math.asin(min(1.0, max(-1.0, -float(R[2, 0]))))
    return math.atan2(R[2, 1], R[2, 2]), pitch, heading(R)


def matrix(quaternion: ArrayLike) -> Array:
    """Rotation matrices, shape (..., 3, 3), of unit quaternions (x, y, z, w), shape (..., 4)."""
    x, y, z, w = _elements(quaternion)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def quaternion(R: Array) -> Quaternion:
    """Unit quaternion (x, y, z, w) of a rotation matrix, shape (3, 3); divides by its largest element."""
    diagonal, trace = np.diag(R), np.trace(R)
    q = np.empty(4)
    if trace >= diagonal.max():
        q[:] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 1.0 + trace
    else:
        i = int(diagonal.argmax())
        j, k = (i + 1) % 3, (i + 2) % 3
        q[[i, j, k, 3]] = 1.0 - trace + 2.0 * R[i, i], R[j, i] + R[i, j], R[k, i] + R[i, k], R[k, j] - R[j, k]
    x, y, z, w = q.tolist()
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm


def roll(quaternion: ArrayLike) -> Array:
    """Roll, rad, positive to the right, shape (...), of unit quaternions (x, y, z, w), shape (..., 4)."""
    x, y, z, w = _elements(quaternion)
    return np.asarray(np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)))


def pitch(quaternion: ArrayLike) -> Array:
    """Pitch, rad, positive nose down, shape (...), of unit quaternions (x, y, z, w), shape (..., 4)."""
    x, y, z, w = _elements(quaternion)
    return np.asarray(np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0)))


def yaw(quaternion: ArrayLike) -> Array:
    """Yaw, rad, positive to the left, shape (...), of unit quaternions (x, y, z, w), shape (..., 4)."""
    x, y, z, w = _elements(quaternion)
    return np.asarray(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def tilt(quaternion: ArrayLike) -> Array:
    """Angle of the z axis to the vertical, rad, shape (...), of unit quaternions (x, y, z, w), (..., 4)."""
    x, y, _, _ = _elements(quaternion)
    return np.asarray(np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0)))


def _elements(quaternion: ArrayLike) -> tuple[Array, Array, Array, Array]:
    q = np.asarray(quaternion, dtype=np.float64)
    return q[..., 0], q[..., 1], q[..., 2], q[..., 3]
