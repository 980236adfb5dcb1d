"""Vectors as plain tuples, in machine code and for the few that are handled once per cycle.

From Python, numpy would cost ten times as much.
"""

from __future__ import annotations

import math

from bridge.types import Array, Vec3
from emulator.compiled import compilable

Rotation = tuple[float, float, float, float, float, float, float, float, float]
"""Rotation matrix, row by row."""


@compilable
def add(a: Vec3, b: Vec3) -> Vec3:
    """The sum a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compilable
def scaled(a: Vec3, factor: float) -> Vec3:
    """The vector times a number."""
    return a[0] * factor, a[1] * factor, a[2] * factor


@compilable
def put(row: Array, a: Vec3) -> None:
    """Write a vector into the first three numbers of a row."""
    row[0], row[1], row[2] = a


@compilable
def cross(a: Vec3, b: Vec3) -> Vec3:
    """The product a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compilable
def length(a: Vec3) -> float:
    """Euclidean norm."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@compilable
def rotate(m: Rotation, a: Vec3) -> Vec3:
    """R a: from the body's frame to the world's."""
    return (
        m[0] * a[0] + m[1] * a[1] + m[2] * a[2],
        m[3] * a[0] + m[4] * a[1] + m[5] * a[2],
        m[6] * a[0] + m[7] * a[1] + m[8] * a[2],
    )


@compilable
def rotate_back(m: Rotation, a: Vec3) -> Vec3:
    """R^T a: from the world's frame to the body's."""
    return (
        m[0] * a[0] + m[3] * a[1] + m[6] * a[2],
        m[1] * a[0] + m[4] * a[1] + m[7] * a[2],
        m[2] * a[0] + m[5] * a[1] + m[8] * a[2],
    )
