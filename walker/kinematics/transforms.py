"""Rotations and homogeneous transforms (Prenner 2011, 2.1 to 2.8).

`R_a_b` turns coordinates of frame b into frame a; yaw is about z, pitch about y, roll about x.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
"""Any array of floats."""
Transform = npt.NDArray[np.float64]
"""A homogeneous transform, shape (4, 4), lengths in m."""


def R_yaw(phi: float) -> Array:
    """Rotation about z by `phi` rad, shape (3, 3) (2.1)."""
    c, s = math.cos(phi), math.sin(phi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def R_pitch(theta: float) -> Array:
    """Rotation about y by `theta` rad, shape (3, 3) (2.2)."""
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def R_roll(psi: float) -> Array:
    """Rotation about x by `psi` rad, shape (3, 3) (2.2)."""
    c, s = math.cos(psi), math.sin(psi)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """R_yaw R_pitch R_roll, angles in rad, shape (3, 3) (2.4)."""
    return R_yaw(yaw) @ R_pitch(pitch) @ R_roll(roll)


def homogeneous(R: Array, d: Sequence[float] | Array) -> Transform:
    """The transform with rotation `R` (3, 3) and origin `d` (3,), m (2.7)."""
    H = np.eye(4)
    H[:3, :3] = R
    H[:3, 3] = d
    return H


def translation(x: float, y: float, z: float) -> Transform:
    """The transform that only shifts, m (2.7 with R = E)."""
    return np.array([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


def inverse(H: Transform) -> Transform:
    """The inverse of a homogeneous transform, by transposing its rotation (2.8)."""
    R_t = H[:3, :3].T
    return homogeneous(R_t, -R_t @ H[:3, 3])
