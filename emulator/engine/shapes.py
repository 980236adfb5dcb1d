"""Shapes of a NAO's links, sized by its data sheet, for pictures and contacts.

One convex shape a link: the shell that touches the floor, an object or another limb, see `link_shapes`. None
of them reaches the ground in a standing, walking or crouching robot. The pairs of limbs in contact are in
`collision_pairs`; every other pair passes through each other, because the ends of the joints' ranges keep it
apart on the robot.
"""

from __future__ import annotations

import itertools
from typing import Final, NamedTuple

import numpy as np

from bridge.body import TORSO, Body
from bridge.body.model import Shapes
from bridge.body.sole import sole_hull
from bridge.types import Array, Quaternion, Side, Vec3
from emulator.poses import Pose, matrix

Colour = tuple[float, float, float, float]
WHITE: Final = (0.92, 0.92, 0.94, 1.0)
GREY: Final = (0.45, 0.47, 0.50, 1.0)
BLUE: Final = (0.10, 0.35, 0.75, 1.0)

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

    vertices: Array
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


def lowest_point(shape: Shape, pose: Pose) -> float:
    """Height of the lowest point of a shape, m, in the frame in which its link has this pose."""
    m = matrix(pose.orientation)
    down, height = np.array(m[6:9]), pose.position[2]
    if isinstance(shape, PrismShape):
        return height + float((shape.vertices @ down).min())
    middle = height + float(down @ shape.centre)
    if isinstance(shape, BoxShape):
        return middle - float(np.abs(down) @ shape.half)
    if isinstance(shape, SphereShape):
        return middle - shape.radius
    turn = matrix(shape.orientation)
    axis = np.array((turn[2], turn[5], turn[8]))
    return middle - 0.5 * shape.length * abs(float(down @ axis)) - shape.radius


def sole_points(body: Body, side: Side) -> Array:
    """Corners of the sole's bottom, (n, 3), AnkleRoll frame, m."""
    outline = sole_hull(body, side)
    return np.column_stack([outline, np.full(len(outline), -body.lengths.FootHeight)])


OUTER_SHARE: Final = 0.3
"""Share of a flat sole's bed that acts at points on its outline; the rest acts at the corners of its pad."""
PAD_SCALE: Final = 0.26
"""Edges of the pad over the sole's. Against tilting, an even bed is a third as stiff as springs in the corners
alone; 0.3 + 0.7 x 0.26^2 = 0.35."""
PATCH_RADIUS: Final = 0.009
"""Mean distance of the ground under one contact point from it, m: with it the torque that turns a flat sole is
that of an even pressure, and a sole on its rim still resists a turn (there it is assumed)."""


def sole_area(body: Body) -> float:
    """Length x width of a sole, m^2."""
    outline = sole_hull(body, "L")
    length, width = outline.max(axis=0) - outline.min(axis=0)
    return float(length * width)


def sole_pad(body: Body, side: Side) -> BoxShape:
    """A plate in the middle of a sole, flush with it: carries the load of a patch away from its outline."""
    outline = sole_hull(body, side)
    low, high = outline.min(axis=0), outline.max(axis=0)
    x, y = (0.5 * (low + high)).tolist()
    half_x, half_y = (0.5 * PAD_SCALE * (high - low)).tolist()
    half_z = 0.25 * SOLE_FRACTION * body.lengths.FootHeight
    return BoxShape((x, y, half_z - body.lengths.FootHeight), (half_x, half_y, half_z), GREY)


def _foot(body: Body, side: Side) -> PrismShape:
    bottom = sole_points(body, side)
    top = bottom + np.array([0.0, 0.0, SOLE_FRACTION * body.lengths.FootHeight])
    return PrismShape(np.vstack([bottom, top]), GREY)


def _limb_x(length: float, radius: float, colour: Colour) -> CapsuleShape:
    """A capsule along x whose first ball sits on the joint; `length` is that between the balls."""
    return CapsuleShape((length / 2.0, 0.0, 0.0), _ALONG_X, radius, length, colour)


def _limb_z(top: float, bottom: float, radius: float, colour: Colour) -> CapsuleShape:
    """A capsule along z between two places of its axis, which are the middles of its balls."""
    return CapsuleShape((0.0, 0.0, (top + bottom) / 2.0), _UPRIGHT, radius, top - bottom, colour)


def _trunk(shapes: Shapes) -> PrismShape:
    """The torso: a block that narrows from the shoulders to the waist."""
    levels = ((shapes.torso_bottom, shapes.waist_width), (shapes.torso_top, shapes.torso_width))
    depth = shapes.torso_depth / 2.0
    corners = [
        (x * depth, y * width / 2.0, z) for z, width in levels for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ]
    return PrismShape(np.array(corners), WHITE)


def link_shapes(body: Body) -> dict[str, Shape]:
    """Shape of each link that has one, by the name of the joint that moves it, in its frame.

    Torso: a tapered block. Head and buttocks (HipRoll): balls. Upper arm, forearm (on an H21 with the hand),
    hand, thigh, shank: capsules; thigh and shank end at hip and ankle, so that the knee is round. Foot: a flat
    prism over the sole's outline. A physics engine takes them as they are, a prism as the hull of its corners.
    """
    length, size = body.lengths, body.shapes
    shapes: dict[str, Shape] = {
        TORSO: _trunk(size),
        "HeadPitch": SphereShape((0.0, 0.0, size.head_height), size.head_radius, WHITE),
    }
    sides: tuple[Side, Side] = ("L", "R")
    for side in sides:
        shapes[f"{side}ShoulderRoll"] = _limb_x(length.UpperArmLength, size.upper_arm_radius, WHITE)
        hand = f"{side}WristYaw" in body.links
        forearm = length.LowerArmLength + (0.0 if hand else length.HandOffsetX)
        shapes[f"{side}ElbowRoll"] = _limb_x(forearm, size.forearm_radius, BLUE)
        if hand:
            shapes[f"{side}WristYaw"] = _limb_x(length.HandOffsetX, size.forearm_radius, GREY)
        shapes[f"{side}HipRoll"] = SphereShape((0.0, 0.0, size.hip_height), size.hip_radius, GREY)
        shapes[f"{side}HipPitch"] = _limb_z(-size.thigh_radius, -length.ThighLength, size.thigh_radius, WHITE)
        shapes[f"{side}KneePitch"] = _limb_z(
            0.0, size.shank_radius - length.TibiaLength, size.shank_radius, BLUE
        )
        shapes[f"{side}AnkleRoll"] = _foot(body, side)
    return shapes


def collision_pairs(body: Body) -> frozenset[tuple[str, str]]:
    """Pairs of links that can touch each other, each pair once.

    Every part of a leg with every part of the other leg; forearm and hand with the trunk, the head, the legs
    and the other forearm and hand. Left out are neighbours, parts of one leg or one arm, upper arm and thigh
    with the trunk: the ends of the joints' ranges keep them apart. The balls of the buttocks touch no part of
    the robot, because they are wider than the real ones next to the hands.
    """
    shapes = link_shapes(body)
    legs = {side: [f"{side}{part}" for part in ("HipPitch", "KneePitch", "AnkleRoll")] for side in "LR"}
    arms = {side: [n for n in (f"{side}ElbowRoll", f"{side}WristYaw") if n in shapes] for side in "LR"}
    forearms = [*arms["L"], *arms["R"]]
    others = [TORSO, "HeadPitch", *legs["L"], *legs["R"]]
    pairs = [*itertools.product(legs["L"], legs["R"]), *itertools.product(arms["L"], arms["R"])]
    return frozenset([*pairs, *itertools.product(forearms, others)])
