"""Shapes, soles and contact parameters in MuJoCo.

A sole touches the floor's plane with points, because MuJoCo gives a mesh on a plane three contacts at most;
everything else touches the sole's prism. Both are made springs by `emulator.engine.mujoco.shapes`. The soft
constraints between all others are set as stiff as the step allows.

Springs of a given stiffness from MuJoCo's soft constraints.

MuJoCo's force in a constraint is (-b v - k d r - a) / R: r the violation (negative), v its rate, a its
acceleration in the step, d the impedance, and R = (1 - d) / d times the inverse inertia that the compiler
found. A spring and damper by implicit Euler is -K (r + h v + h^2 a) - B (v + h a). Both are the same with
1 / R = K h^2 + B h, the constraint's apparent mass, on a link of any mass.

Soles in MuJoCo: a bed of springs at points of the outline and one in the middle.

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

from bridge.body import Body
from bridge.body.sole import sole_hull
from bridge.types import Array, Quaternion, Side
from emulator.engine.mujoco.client import mujoco
from emulator.engine.shapes import (
    FOOT_LINKS,
    GREY,
    SOLE_FRACTION,
    BoxShape,
    CapsuleShape,
    PrismShape,
    Shape,
    SphereShape,
    collision_pairs,
    link_shapes,
    sole_area,
    sole_points,
)
from emulator.engine.values import Surface

Numbers = tuple[float, ...]
SOLE_POINTS: Final = 8
"""Contact points of the outline with the floor: their hull is within 1 mm of the whole outline's."""
_PRISM_POINTS: Final = 4
"""Contacts that MuJoCo finds between a prism and the flat side of a box."""
TOP_POINTS: Final = 4
"""Points of the foot's upper side, for a foot upside down on the floor."""
POINT_RADIUS: Final = 0.001
"""Radius of the ball at each point, m."""
TIME_CONSTANT_STEPS: Final = 3.0
"""Time constant of the contacts and stops in physics steps; MuJoCo takes no less than two."""
IMPEDANCE: Final = (0.99, 0.999, 0.0001, 0.5, 2.0)
"""Impedance of contacts, stops and the hips' gear: how little a constraint gives way to its load."""
GROUND_GROUP, ROBOT_GROUP, OBJECT_GROUP, HIDDEN_GROUP = range(4)
"""Geom groups, for rays and pictures; hidden ones are neither hit nor seen."""
ROBOT_BITS: Final = range(4, 31)
"""Bits by which MuJoCo lets one robot touch the others."""
_POINT, _SOLE, _LINK, _OBJECT = 1, 2, 4, 8
"""Bits by which MuJoCo chooses the pairs that can touch; limbs that can are pairs of their own."""
MASKS: Final[dict[str, tuple[int, int]]] = {
    "sole point": (_POINT, 0),
    "sole": (_SOLE, 0),
    "shell": (_LINK, 0),
    "plane for soles": (0, _POINT | _OBJECT),
    "ground for soles": (0, _SOLE | _OBJECT),
    "object for soles": (0, _SOLE),
    "object": (_OBJECT, _OBJECT),
    "ball": (_OBJECT, _OBJECT),
    "for the shell": (0, _LINK),
}
"""`contype` and `conaffinity` by kind of geom. Whatever a robot can touch is there twice, for soles and for the
shell, because MuJoCo takes a pair's friction from one of the two and does not multiply; an object a third time,
for the ground and other objects."""
_PRIORITY: Final = {"ball": 3, "object": 1, "shell": 0}
"""Whose friction and stiffness count, the ground's, a sole's and all for soles or the shell being 2; a ball's
because only it has rolling friction. Of a sole
and its partner, equal in rank, the friction is the greater one, which is not the sole's, and the stiffness
the sole's, because only its `solmix` is not 0."""
_SOLES: Final = ("sole point", "sole")


def spring(
    stiffness: float, relaxation: float, step: float, inverse_inertia: float
) -> tuple[tuple[float, float], Numbers]:
    """`solref` and `solimp` of a spring with a damper.

    Args:
        stiffness: K, N/m or N m/rad.
        relaxation: B / K, s.
        step: Physics step h, s.
        inverse_inertia: MuJoCo's `invweight0` of the constrained body, 1/kg or 1/(kg m^2).
    """
    per_rate = stiffness * (step + relaxation)
    mass = per_rate * step
    impedance = 1.0 / (1.0 + 1.0 / (mass * inverse_inertia))
    # in MuJoCo's direct form both are divided by the impedance
    reference = (-stiffness / mass * impedance, -per_rate / mass * impedance)
    return reference, (impedance, impedance, 0.001, 0.5, 2.0)


class Bed(NamedTuple):
    """Points of one sole, the last one in its middle."""

    points: Array
    """AnkleRoll frame, (n, 3), m."""
    shares: Array
    """Share of each point in the bed's stiffness, (n,), sum 1."""
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
    """Mean distance of the points of a rectangle from its middle, m: lever of friction under even pressure."""
    a, b, d = length, width, math.hypot(length, width)
    along = d + a * a / (2.0 * b) * math.log((b + d) / a)
    return (along + b * b / (2.0 * a) * math.log((a + d) / b)) / 6.0


def fewer(outline: Array, number: int) -> Array:
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


def soften_soles(model: Any, body: Body, surface: Surface, prefix: str) -> None:
    """Give both soles the springs of a surface.

    Args:
        model: MuJoCo's, with a robot.
        body: Data sheet of the robot.
        surface: Under it.
        prefix: Of the names of its parts.
    """
    whole = surface.stiffness_per_area * sole_area(body)
    for side, name in FOOT_LINKS.items():
        bed, link = sole_bed(body, side), prefix + name
        for number, share in enumerate(bed.shares.tolist()):
            _set_spring(model, point_name(link, number), share * whole, surface.relaxation)
        _set_spring(model, link, whole / _PRISM_POINTS, surface.relaxation)
        model.geom(point_name(link, len(bed.shares) - 1)).friction[1] = surface.friction * bed.twist


def _set_spring(model: Any, name: str, stiffness: float, relaxation: float) -> None:
    """Make the contacts of a geom springs: stiffness in N/m, damping over stiffness in s."""
    geom = model.geom(name)
    inertia = model.body_invweight0[geom.bodyid[0], 0]
    geom.solref, geom.solimp = spring(stiffness, relaxation, model.opt.timestep, inertia)


def wxyz(turn: Quaternion) -> tuple[float, float, float, float]:
    """MuJoCo's order of a quaternion."""
    return turn[3], turn[0], turn[1], turn[2]


def xyzw(turn: Any) -> Quaternion:
    """The project's order of a quaternion."""
    w, x, y, z = turn.tolist()
    return x, y, z, w


def contact_options(kind: str, step: float) -> dict[str, Any]:
    """Options of a geom: its possible partners, and its stiffness.

    Args:
        kind: Of `MASKS`.
        step: Physics step, s.
    """
    contype, conaffinity = MASKS[kind]
    return {
        "contype": contype,
        "conaffinity": conaffinity,
        "condim": 6 if kind == "ball" else 3,
        "priority": _PRIORITY.get(kind, 2),
        "solmix": 1.0 if kind in _SOLES else 0.0,
        "solref": (TIME_CONSTANT_STEPS * step, 1.0),
        "solimp": IMPEDANCE,
        "friction": (0.0, 0.0, 0.0),
    }


def add_link_shape(spec: Any, link: Any, name: str, shape: Shape, step: float, prefix: str) -> Any:
    """Give a link of the robot its shape, and return its description.

    Args:
        spec: Of the model.
        link: Its body.
        name: Of the link.
        shape: In the link's frame.
        step: Physics step, s.
        prefix: Of the names of the robot's parts.
    """
    options = {"group": ROBOT_GROUP, "rgba": shape.colour, "mass": 0.0}
    sole, name = name in FOOT_LINKS.values(), prefix + name
    if not isinstance(shape, PrismShape):
        return link.add_geom(name=name, **_primitive(shape), **options, **contact_options("shell", step))
    spec.add_mesh(name=name, uservert=shape.vertices.ravel().tolist())
    kind = contact_options("sole" if sole else "shell", step)
    return link.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **options, **kind)


def add_sole_points(body: Body, side: Side, link: Any, step: float, prefix: str) -> None:
    """Give a foot its contact points with the floor: those of its bed, and its upper side's.

    Args:
        body: Data sheet.
        side: Of the foot.
        link: Its body in the model.
        step: Physics step, s.
        prefix: Of the names of the robot's parts.
    """
    bed, top = sole_bed(body, side).points, sole_points(body, side)
    top[:, 2] += SOLE_FRACTION * body.lengths.FootHeight
    for number, (x, y, z) in enumerate((*bed.tolist(), *fewer(top, TOP_POINTS).tolist())):
        geom = link.add_geom(
            name=point_name(prefix + FOOT_LINKS[side], number),
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=(POINT_RADIUS, 0.0, 0.0),
            pos=(x, y, z + POINT_RADIUS),
            group=ROBOT_GROUP,
            rgba=GREY,
            mass=0.0,
            **contact_options("sole point", step),
        )
        if number == len(bed) - 1:
            geom.condim = 4


def add_limb_pairs(spec: Any, body: Body, step: float, prefix: str) -> None:
    """Pairs of links that can touch each other; MuJoCo tries no others of the robot.

    Args:
        spec: With the links' shapes.
        body: Data sheet.
        step: Physics step, s.
        prefix: Of the names of the robot's parts.
    """
    soles, shell_friction = FOOT_LINKS.values(), body.shapes.shell_friction
    shell = {name: 1.0 if name in soles else shell_friction for name in link_shapes(body)}
    for first, second in sorted(collision_pairs(body)):
        friction = shell[first] * shell[second]
        spec.add_pair(
            geomname1=prefix + first,
            geomname2=prefix + second,
            condim=3,
            friction=(friction, friction, 0.0, 0.0, 0.0),
            solref=(TIME_CONSTANT_STEPS * step, 1.0),
            solimp=IMPEDANCE,
        )


def _primitive(shape: BoxShape | CapsuleShape | SphereShape) -> dict[str, Any]:
    kinds = mujoco.mjtGeom
    if isinstance(shape, BoxShape):
        return {"type": kinds.mjGEOM_BOX, "pos": shape.centre, "size": shape.half}
    if isinstance(shape, SphereShape):
        return {"type": kinds.mjGEOM_SPHERE, "pos": shape.centre, "size": (shape.radius, 0.0, 0.0)}
    size = (shape.radius, shape.length / 2.0, 0.0)
    return {"type": kinds.mjGEOM_CAPSULE, "pos": shape.centre, "quat": wxyz(shape.orientation), "size": size}
