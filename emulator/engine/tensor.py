"""Inertia tensors of the data sheet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bridge.body.model import Tensor


def tensor_matrix(tensor: Tensor) -> NDArray[np.float64]:
    """Symmetric 3 x 3 matrix of the elements (ixx, iyy, izz, ixy, ixz, iyz), kg m^2."""
    ixx, iyy, izz, ixy, ixz, iyz = tensor
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
