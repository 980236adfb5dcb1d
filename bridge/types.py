"""Shared types: checked numbers, vectors, sides, and arrays of numpy.

msgspec checks the bounds wherever a struct has a field of such a type: on the wire and in a file.
"""

from __future__ import annotations

import sys
from typing import Annotated, Final, Literal, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

MAX_INT: Final = 2**63 - 1
"""Largest integer of a message."""

Finite = Annotated[float, msgspec.Meta(ge=-sys.float_info.max, le=sys.float_info.max)]
"""Neither NaN nor infinite; an integer on the wire is taken for a float."""
Bounded = Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)]
"""Farther out than any emulated world reaches, and small enough to square."""
Positive = Annotated[float, msgspec.Meta(gt=0.0, le=1e9)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0, le=1e9)]
Fraction = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
"""From 0 to 1: a probability, a stiffness, a charge, a part of a whole."""
Count = Annotated[int, msgspec.Meta(ge=0, le=MAX_INT)]

Vec2 = tuple[Finite, Finite]
Vec3 = tuple[Finite, Finite, Finite]
Matrix3 = tuple[Vec3, Vec3, Vec3]
"""Rows of a matrix in plain floats: numpy takes longer at this size."""
Quaternion = tuple[Finite, Finite, Finite, Finite]
"""(x, y, z, w), a unit quaternion."""
Pose = tuple[Finite, Finite, Finite, Finite, Finite, Finite]
"""x, y, z, m, and roll, pitch, yaw, rad; orientation: R_yaw R_pitch R_roll."""

Side = Literal["L", "R"]
"""Left or right."""
SIDES: Final[tuple[Side, Side]] = ("L", "R")
"""Order of every pair of values."""

Array = NDArray[np.float64]
"""Floats; the shape is in the docstring of the function."""

C = TypeVar("C", bound="Closing")


class Closing:
    """Base of a context manager that closes itself at its end."""

    def close(self) -> None:
        """Close it."""
        raise NotImplementedError

    def __enter__(self: C) -> C:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
