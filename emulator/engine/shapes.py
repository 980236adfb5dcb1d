"""Primitive shapes of a NAO, sized from the lengths of the data sheet, for looks and contacts.

Only the sole is measured (data sheet). The other shapes are assumed: thin enough that none of them reaches the
ground in a standing, walking or crouching robot, large enough that a fallen one lies on them.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from bridge.body import TORSO, Body
from bridge.types import Quaternion, Side, Vec3

Colour = tuple[float, float, float, float]
WHITE: Final = (0.92, 0.92, 0.94, 1.0)
GREY: Final = (0.45, 0.47, 0.50, 1.0)
BLUE: Final = (0.10, 0.35, 0.75, 1.0)

TORSO_DEPTH: Final = 0.10
HEAD_RADIUS: Final = 0.065
ARM_RADIUS: Final = 0.025
LEG_RADIUS: Final = 0.032
SOLE_FRACTION: Final = 0.6
"""Fraction of the foot height that the sole's body fills; the rest is free for the ankle."""

FOOT_LINKS: Final[dict[Side, str]] = {"L": "LAnkleRoll", "R": "RAnkleRoll"}
"""Links whose shapes are the soles."""
_ALONG_X: Final = (0.0, 0.7071067811865476, 0.0, 0.7071067811865476)
_UPRIGHT: Final = (0.0, 0.0, 0.0, 1.0)


class BoxShape(NamedTuple):
    """A box by its half extents, m."""

    centre: Vec3
    half: Vec3
    colour: Colour


class CapsuleShape(NamedTuple):
    """A capsule by radius and length of its cylinder, m; the axis is z turned by `orientation`."""

    centre: Vec3
    orientation: Quaternion
    radius: float
    length: float
    colour: Colour


class SphereShape(NamedTuple):
    """A ball, m."""

    centre: Vec3
    radius: float
    colour: Colour


class PrismShape(NamedTuple):
    """An upright prism over a convex outline, m: first the vertices at the bottom, then those at the top."""

    vertices: NDArray[np.float64]
    colour: Colour

    def triangles(self) -> list[int]:
        """Indices of the faces, outward."""
        n = len(self.vertices) // 2
        faces: list[int] = []
        for i in range(1, n - 1):
            faces += [0, i + 1, i, n, n + i, n + i + 1]
        for i in range(n):
            j = (i + 1) % n
            faces += [i, j, n + j, i, n + j, n + i]
        return faces


Shape = BoxShape | CapsuleShape | SphereShape | PrismShape


def sole_outline(body: Body, side: Side) -> NDArray[np.float64]:
    """Convex outline of a sole, counter-clockwise, (n, 2), AnkleRoll frame projected to the ground, m.

    The right foot mirrors y (data sheet). Dents of the true outline cannot carry and drop out.
    """
    mirror = 1.0 if side == "L" else -1.0
    points = np.array(body.foot.sole) * (1.0, mirror)
    return np.asarray(points[ConvexHull(points).vertices], dtype=np.float64)


def sole_points(body: Body, side: Side) -> NDArray[np.float64]:
    """Corners of the sole's bottom, (n, 3), AnkleRoll frame, m."""
    outline = sole_outline(body, side)
    return np.column_stack([outline, np.full(len(outline), -body.lengths.FootHeight)])


def _foot(body: Body, side: Side) -> PrismShape:
    bottom = sole_points(body, side)
    top = bottom + np.array([0.0, 0.0, SOLE_FRACTION * body.lengths.FootHeight])
    return PrismShape(np.vstack([bottom, top]), GREY)


def _limb_x(length: float, colour: Colour) -> CapsuleShape:
    return CapsuleShape((length / 2.0, 0.0, 0.0), _ALONG_X, ARM_RADIUS, length, colour)


def _limb_z(length: float, colour: Colour) -> CapsuleShape:
    return CapsuleShape((0.0, 0.0, -length / 2.0), _UPRIGHT, LEG_RADIUS, length, colour)


def link_shapes(body: Body) -> dict[str, Shape]:
    """Shape of each link that has one, by the name of the joint that moves it, in its frame."""
    length = body.lengths
    top, bottom = length.ShoulderOffsetZ + 0.02, -length.HipOffsetZ
    shapes: dict[str, Shape] = {
        TORSO: BoxShape(
            (0.0, 0.0, (top + bottom) / 2.0),
            (TORSO_DEPTH / 2.0, length.ShoulderOffsetY - ARM_RADIUS, (top - bottom) / 2.0),
            WHITE,
        ),
        "HeadPitch": SphereShape((0.0, 0.0, HEAD_RADIUS - 0.01), HEAD_RADIUS, WHITE),
    }
    sides: tuple[Side, Side] = ("L", "R")
    for side in sides:
        shapes[f"{side}ShoulderRoll"] = _limb_x(length.UpperArmLength, WHITE)
        hand = f"{side}WristYaw" in body.links
        forearm = length.LowerArmLength + (0.0 if hand else length.HandOffsetX)
        shapes[f"{side}ElbowRoll"] = _limb_x(forearm, BLUE)
        if hand:
            shapes[f"{side}WristYaw"] = _limb_x(length.HandOffsetX, GREY)
        shapes[f"{side}HipPitch"] = _limb_z(length.ThighLength, WHITE)
        shapes[f"{side}KneePitch"] = _limb_z(length.TibiaLength, BLUE)
        shapes[f"{side}AnkleRoll"] = _foot(body, side)
    return shapes
