"""Shapes and contact parameters in MuJoCo.

A sole meets the floor's plane with points, because MuJoCo gives a mesh on a plane three contacts at most;
everything else meets the sole's prism. Both are made springs by `emulator.engine.mujoco.soles`. The soft
constraints between all others are set as stiff as the step allows.
"""

from __future__ import annotations

from typing import Any, Final

from bridge.body import Body
from bridge.types import Quaternion, Side
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.soles import fewer, point_name, sole_bed
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
    sole_points,
)

TOP_POINTS: Final = 4
"""Points of the foot's upper side, for a foot that lies on the floor."""
POINT_RADIUS: Final = 0.001
"""Of the ball at each point, m."""
TIME_CONSTANT_STEPS: Final = 3.0
"""Time constant of the contacts and stops in physics steps; MuJoCo takes no less than two."""
STIFF: Final = (0.99, 0.999, 0.0001, 0.5, 2.0)
"""Impedance of contacts, stops and the hips' gear: how little a constraint gives way to its load."""

GROUND_GROUP, ROBOT_GROUP, OBJECT_GROUP, HIDDEN_GROUP = range(4)
"""Geom groups, for rays and pictures; what is hidden is neither hit nor seen."""
_POINT, _SOLE, _LINK, _OBJECT = 1, 2, 4, 8
"""Bits by which MuJoCo chooses the pairs that can touch; limbs that meet are pairs of their own."""
MASKS: Final[dict[str, tuple[int, int]]] = {
    "sole point": (_POINT, 0),
    "sole": (_SOLE, 0),
    "shell": (_LINK, 0),
    "plane for soles": (0, _POINT | _OBJECT),
    "ground for soles": (0, _SOLE | _OBJECT),
    "object for soles": (0, _SOLE),
    "object": (_OBJECT, _OBJECT),
    "for the shell": (0, _LINK),
}
"""`contype` and `conaffinity` by kind of geom. What a robot can touch is there twice, for soles and for the
shell, because MuJoCo takes a pair's friction from one of the two and does not multiply; an object a third time,
for the ground and other objects."""
_PRIORITY: Final = {"object": 1, "shell": 0}
"""Whose friction and stiffness count, the ground's, a sole's and all for soles or the shell being 2. Of a sole
and what it meets, equal in rank, the friction is the greater one, which is not the sole's, and the stiffness
the sole's, because only its `solmix` is not 0."""
_SOLES: Final = ("sole point", "sole")


def wxyz(turn: Quaternion) -> tuple[float, float, float, float]:
    """MuJoCo's order of a quaternion."""
    return turn[3], turn[0], turn[1], turn[2]


def xyzw(turn: Any) -> Quaternion:
    """The project's order of a quaternion."""
    w, x, y, z = turn.tolist()
    return x, y, z, w


def contact_options(kind: str, step: float) -> dict[str, Any]:
    """Options of a geom: what it may touch, and how stiff.

    Args:
        kind: Of `MASKS`.
        step: Physics step, s.
    """
    contype, conaffinity = MASKS[kind]
    return {
        "contype": contype,
        "conaffinity": conaffinity,
        "condim": 3,
        "priority": _PRIORITY.get(kind, 2),
        "solmix": 1.0 if kind in _SOLES else 0.0,
        "solref": (TIME_CONSTANT_STEPS * step, 1.0),
        "solimp": STIFF,
        "friction": (0.0, 0.0, 0.0),
    }


def add_link_shape(spec: Any, link: Any, name: str, shape: Shape, step: float) -> None:
    """Give a link of the robot its shape.

    Args:
        spec: Of the model.
        link: Its body.
        name: Of the link.
        shape: In the link's frame.
        step: Physics step, s.
    """
    options = {"group": ROBOT_GROUP, "rgba": shape.colour, "mass": 0.0}
    if not isinstance(shape, PrismShape):
        link.add_geom(name=name, **_primitive(shape), **options, **contact_options("shell", step))
        return
    sole = name in FOOT_LINKS.values()
    spec.add_mesh(name=name, uservert=shape.vertices.ravel().tolist())
    kind = contact_options("sole" if sole else "shell", step)
    link.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **options, **kind)


def add_sole_points(body: Body, side: Side, link: Any, step: float) -> None:
    """Give a foot the points by which it meets the floor: those of its bed, and its upper side's.

    Args:
        body: Data sheet.
        side: Of the foot.
        link: Its body in the model.
        step: Physics step, s.
    """
    bed, top = sole_bed(body, side).points, sole_points(body, side)
    top[:, 2] += SOLE_FRACTION * body.lengths.FootHeight
    for number, (x, y, z) in enumerate((*bed.tolist(), *fewer(top, TOP_POINTS).tolist())):
        geom = link.add_geom(
            name=point_name(FOOT_LINKS[side], number),
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


def let_limbs_meet(spec: Any, body: Body, step: float) -> None:
    """Pairs of links that can meet each other; MuJoCo tries no others of the robot.

    Args:
        spec: With the links' shapes.
        body: Data sheet.
        step: Physics step, s.
    """
    soles, shell_friction = FOOT_LINKS.values(), body.shapes.shell_friction
    shell = {name: 1.0 if name in soles else shell_friction for name in link_shapes(body)}
    for first, second in sorted(collision_pairs(body)):
        friction = shell[first] * shell[second]
        spec.add_pair(
            geomname1=first,
            geomname2=second,
            condim=3,
            friction=(friction, friction, 0.0, 0.0, 0.0),
            solref=(TIME_CONSTANT_STEPS * step, 1.0),
            solimp=STIFF,
        )


def _primitive(shape: BoxShape | CapsuleShape | SphereShape) -> dict[str, Any]:
    kinds = mujoco.mjtGeom
    if isinstance(shape, BoxShape):
        return {"type": kinds.mjGEOM_BOX, "pos": shape.centre, "size": shape.half}
    if isinstance(shape, SphereShape):
        return {"type": kinds.mjGEOM_SPHERE, "pos": shape.centre, "size": (shape.radius, 0.0, 0.0)}
    size = (shape.radius, shape.length / 2.0, 0.0)
    return {
        "type": kinds.mjGEOM_CAPSULE,
        "pos": shape.centre,
        "quat": wxyz(shape.orientation),
        "size": size,
    }
