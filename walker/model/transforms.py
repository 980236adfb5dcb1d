"""Homogeneous transforms (Prenner 2011, 2.7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bridge.types import Array

Transform = Array
"""A homogeneous transform, shape (4, 4), lengths in m."""


def homogeneous(R: Array, d: Sequence[float] | Array) -> Transform:
    """The transform with a rotation and an origin, shape (4, 4) (2.7).

    Args:
        R: rotation, shape (3, 3).
        d: origin, shape (3,), m.
    """
    H = np.zeros((4, 4))
    H[:3, :3] = R
    H[:3, 3] = d
    H[3, 3] = 1.0
    return H


def translation(x: float, y: float, z: float) -> Transform:
    """The transform that only shifts, m (2.7 with R = E)."""
    return np.array([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])
