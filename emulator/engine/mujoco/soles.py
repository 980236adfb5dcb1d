"""Soles in MuJoCo: a bed of springs at points of the outline and one in the middle.

The shares of the points in the bed are chosen so that a flat sole sinks, and tilts about both axes, as an
evenly pressed rectangle on its bed does; the point in the middle has the torque that is missing against a turn
on the spot. Known weaknesses: a sole on its rim sinks by springs in a few points, not along a line; on boxes
and heightfields the sole's prism has the bed at the points where MuJoCo finds contact, mostly corners, and
tilts less there.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.sole import sole_hull
from bridge.types import Side
from emulator.engine.mujoco.springs import spring
from emulator.engine.shapes import FOOT_LINKS, sole_area, sole_points
from emulator.engine.values import Surface

SOLE_POINTS: Final = 8
"""Points of the outline that meet the floor: the hull of these is within 1 mm of the whole outline's."""
_PRISM_POINTS: Final = 4
"""Contacts that MuJoCo finds between a prism and the flat side of a box."""


class Bed(NamedTuple):
    """Points of one sole, the last one in its middle."""

    points: NDArray[np.float64]
    """AnkleRoll frame, (n, 3), m."""
    shares: NDArray[np.float64]
    """Of each point in the bed's stiffness, (n,), sum 1."""
    twist: float
    """Torque against a turn on the spot over the friction force, in the point in the middle, m."""


def sole_bed(body: Body, side: Side) -> Bed:
    """The bed of one sole: zeroth, first and second moments of a rectangle of its length and width."""
    outline = sole_hull(body, side)
    low, high = outline.min(axis=0), outline.max(axis=0)
    middle, (length, width) = 0.5 * (low + high), high - low
    corners = fewer(sole_points(body, side), SOLE_POINTS)
    points = np.vstack([corners, (*middle, corners[0, 2])])
    x, y = ((points[:, :2] - middle) / (length, width)).T
    moments = np.array([np.ones_like(x), x, y, x * x, y * y, x * y])
    shares = np.linalg.lstsq(moments, np.array([1.0, 0.0, 0.0, 1.0 / 12.0, 1.0 / 12.0, 0.0]), rcond=None)[0]
    lever = float(shares @ np.linalg.norm(points[:, :2] - middle, axis=1))
    twist = (mean_distance(float(length), float(width)) - lever) / float(shares[-1])
    return Bed(points, shares, twist)


def mean_distance(length: float, width: float) -> float:
    """Of the points of a rectangle from its middle, m: lever of the friction of an evenly pressed one."""
    a, b, d = length, width, math.hypot(length, width)
    along = d + a * a / (2.0 * b) * math.log((b + d) / a)
    return (along + b * b / (2.0 * a) * math.log((a + d) / b)) / 6.0


def fewer(outline: NDArray[np.float64], number: int) -> NDArray[np.float64]:
    """The points of a convex outline whose hull loses least area, one after the other taken away.

    Args:
        outline: In order, (n, 3), m.
        number: Of points that are left.
    """
    points = outline
    while len(points) > number:
        before, after = np.roll(points, 1, axis=0) - points, np.roll(points, -1, axis=0) - points
        area = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
        points = np.delete(points, int(area.argmin()), axis=0)
    return points


def point_name(link: str, number: int) -> str:
    """Name of the geom at a point of a foot's bed."""
    return f"{link} bed {number}"


def soften_soles(model: Any, body: Body, surface: Surface) -> None:
    """Give both soles the springs of a surface.

    Args:
        model: MuJoCo's, with a robot.
        body: Data sheet of the robot.
        surface: Under it.
    """
    whole = surface.stiffness_per_area * sole_area(body)
    for side, link in FOOT_LINKS.items():
        bed = sole_bed(body, side)
        for number, share in enumerate(bed.shares.tolist()):
            _set_spring(model, point_name(link, number), share * whole, surface.relaxation)
        _set_spring(model, link, whole / _PRISM_POINTS, surface.relaxation)
        model.geom(point_name(link, len(bed.shares) - 1)).friction[1] = surface.friction * bed.twist


def _set_spring(model: Any, name: str, stiffness: float, relaxation: float) -> None:
    """Make the contacts of a geom springs: stiffness in N/m, damping over stiffness in s."""
    geom = model.geom(name)
    inertia = model.body_invweight0[geom.bodyid[0], 0]
    geom.solref, geom.solimp = spring(stiffness, relaxation, model.opt.timestep, inertia)
