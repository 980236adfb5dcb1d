"""Inertia tensors as PyBullet takes them: principal moments in a frame of their own.

PyBullet stores three moments per link and an inertial frame. A full tensor is therefore handed over as its
principal moments, and the inertial frame is turned into the principal axes: nothing of it is lost.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.rotations import quaternion
from bridge.types import Quaternion, Vec3

Matrix = NDArray[np.float64]


class PrincipalInertia(NamedTuple):
    """A tensor as moments about its own axes."""

    moments: Vec3
    """kg m^2"""
    orientation: Quaternion
    """Of the principal axes in the link frame, (x, y, z, w)."""


def with_rotor(tensor: Matrix, axis: Vec3, rotor: float) -> Matrix:
    """The tensor with a reflected rotor inertia about the joint axis, kg m^2, (3, 3).

    A rotor behind a gear of ratio n acts on its joint as J n^2. PyBullet has no armature, so the amount is
    added to the link as a rank-one term. Known weakness: it also resists a rotation of the whole limb about
    that axis, which a real rotor does only by 1 / n.

    Args:
        tensor: Of the link, (3, 3), kg m^2.
        axis: Of the joint, unit vector.
        rotor: Reflected inertia, kg m^2.
    """
    a = np.array(axis)
    return tensor + rotor * np.outer(a, a)


def principal(tensor: Matrix) -> PrincipalInertia:
    """Principal moments and axes of a symmetric positive definite tensor, kg m^2."""
    moments, axes = np.linalg.eigh(tensor)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    return PrincipalInertia((float(moments[0]), float(moments[1]), float(moments[2])), quaternion(axes))
