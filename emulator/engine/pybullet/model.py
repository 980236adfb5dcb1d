"""The robot as a PyBullet multibody, built from the data sheet when it starts.

Link frames are the zero-pose aligned joint frames of the data sheet. The free base is the torso.

Inertia tensors as PyBullet takes them: principal moments in a frame of their own.

PyBullet stores three moments per link and an inertial frame. A full tensor is therefore handed over as its
principal moments, and the inertial frame is turned into the principal axes: nothing of it is lost.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from bridge.body import TORSO, Body, JointTree, joint_tree
from bridge.body.model import Link
from bridge.body.quantities import tensor_matrix
from bridge.rotations import quaternion
from bridge.types import Array, Quaternion, Side, Vec3
from emulator.engine.pybullet.client import bullet
from emulator.engine.shapes import (
    FOOT_LINKS,
    BoxShape,
    CapsuleShape,
    PrismShape,
    Shape,
    SphereShape,
    collision_pairs,
    link_shapes,
    sole_area,
    sole_pad,
)
from emulator.poses import Pose

BASE: Final = -1
"""PyBullet's link number of the torso."""
GEAR_TORQUE: Final = 100.0
"""Maximum torque of the gear between the hips, N m: far above the motor's stall torque."""
GEAR_ERP: Final = 0.2
"""Fraction of a difference between the two hips that one physics step takes back."""
HULL_MARGIN: Final = 0.001
"""Margin that PyBullet adds below a convex hull on a plane, m (measured; fixed on links)."""
_UPRIGHT: Final = (0.0, 0.0, 0.0, 1.0)
_HERE: Final = (0.0, 0.0, 0.0)
_PAD: Final = " pad"
"""Suffix of the plate in the middle of a sole. PyBullet numbers links depth first: it follows its foot."""
_NO_SHAPE: Final = -1
_NO_MASS: Final = 1e-9
"""kg; PyBullet takes a link of mass 0 for a fixed one."""


class PrincipalInertia(NamedTuple):
    """A tensor as moments about its own axes."""

    moments: Vec3
    """kg m^2"""
    orientation: Quaternion
    """Orientation of the principal axes in the link frame, (x, y, z, w)."""


def with_rotor(tensor: Array, axis: Vec3, rotor: float) -> Array:
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


def principal(tensor: Array) -> PrincipalInertia:
    """Principal moments and axes of a symmetric positive definite tensor, kg m^2."""
    moments, axes = np.linalg.eigh(tensor)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    return PrincipalInertia((float(moments[0]), float(moments[1]), float(moments[2])), quaternion(axes))


_NO_INERTIA: Final = PrincipalInertia((1e-12, 1e-12, 1e-12), _UPRIGHT)


@dataclass(frozen=True)
class BulletModel:
    """A robot in a physics client."""

    client: int
    robot: int
    """PyBullet's number of the multibody."""
    joints: tuple[str, ...]
    """Mechanical joints."""
    numbers: tuple[int, ...]
    """PyBullet's number of each joint, and of the link that it moves."""
    feet: dict[Side, int]
    """Link numbers of the feet."""
    pads: dict[Side, int]
    """Link numbers of the plates in the middle of the soles, without mass."""
    sole_area: float
    """Length x width of a sole, m^2."""
    pairs: tuple[tuple[int, int], ...]
    """Numbers of the links that can touch each other."""
    masses: tuple[float, ...]
    """Torso first, then the links in joint order, kg."""
    torso_com: Vec3
    """Centre of mass of the torso link in the Torso frame, m."""
    torso_principal: tuple[float, float, float, float]
    """Orientation of the torso's inertial frame in the Torso frame."""

    def link_frame(self, link: int) -> Pose:
        """Pose of a link's frame in the world now, by PyBullet's number of the link; not of the torso."""
        state = bullet.getLinkState(
            self.robot, link, computeForwardKinematics=True, physicsClientId=self.client
        )
        return Pose(state[4], state[5])


def _geometry(shape: Shape, *, visual: bool) -> dict[str, Any]:
    """PyBullet's arguments for a shape."""
    length = "length" if visual else "height"
    if isinstance(shape, BoxShape):
        return {"shapeType": bullet.GEOM_BOX, "halfExtents": shape.half}
    if isinstance(shape, CapsuleShape):
        return {"shapeType": bullet.GEOM_CAPSULE, "radius": shape.radius, length: shape.length}
    if isinstance(shape, SphereShape):
        return {"shapeType": bullet.GEOM_SPHERE, "radius": shape.radius}
    if visual:
        return {
            "shapeType": bullet.GEOM_MESH,
            "vertices": shape.vertices.tolist(),
            "indices": shape.triangles(),
        }
    return {"shapeType": bullet.GEOM_MESH, "vertices": _raised(shape).tolist()}


def _raised(prism: PrismShape) -> Array:
    """Vertices with the bottom raised by the margin that PyBullet adds below."""
    vertices: Array = prism.vertices.copy()
    vertices[: len(vertices) // 2, 2] += HULL_MARGIN
    return vertices


def _create_shape(client: int, shape: Shape) -> tuple[int, int]:
    """Collision and visual shape numbers."""
    centre = _HERE if isinstance(shape, PrismShape) else shape.centre
    turn = shape.orientation if isinstance(shape, CapsuleShape) else _UPRIGHT
    collision = bullet.createCollisionShape(
        collisionFramePosition=centre,
        collisionFrameOrientation=turn,
        physicsClientId=client,
        **_geometry(shape, visual=False),
    )
    visual = bullet.createVisualShape(
        visualFramePosition=centre,
        visualFrameOrientation=turn,
        rgbaColor=shape.colour,
        physicsClientId=client,
        **_geometry(shape, visual=True),
    )
    return int(collision), int(visual)


def combined_inertia(link: Link, joint: JointTree, rotor_inertia: float) -> PrincipalInertia:
    """Principal inertia of a link together with the reflected rotor of the joint that moves it."""
    return principal(with_rotor(tensor_matrix(link.inertia), joint.axis, rotor_inertia))


def build_model(client: int, body: Body, *, rotor_inertia: Sequence[float], fixed: bool = False) -> BulletModel:
    """Put a robot in its zero pose, torso upright at the world's origin, into a physics client.

    Args:
        client: Physics client.
        body: Data sheet.
        rotor_inertia: Reflected rotor inertia about each joint's axis, in the tree's order of joints, kg m^2.
        fixed: Nail the torso to the world (for tests and test benches).
    """
    tree = joint_tree(body)
    names = tuple(tree)
    links = [
        link for name in names for link in ((name, name + _PAD) if name in FOOT_LINKS.values() else (name,))
    ]
    number = {TORSO: BASE} | {link: i for i, link in enumerate(links)}
    shapes = {name: _create_shape(client, shape) for name, shape in link_shapes(body).items()}
    for side, foot in FOOT_LINKS.items():
        shapes[foot + _PAD] = _create_shape(client, sole_pad(body, side))[0], _NO_SHAPE
    torso = body.links[TORSO]
    inertias = {TORSO: principal(tensor_matrix(torso.inertia))} | {
        name: combined_inertia(body.links[name], tree[name], rotor)
        for name, rotor in zip(names, rotor_inertia, strict=True)
    }
    robot = _create_multibody(client, body, number, shapes, inertias, fixed)
    for link, i in number.items():
        _set_dynamics(client, robot, i, inertias.get(link, _NO_INERTIA))
        if link in tree:
            sheet = body.joints[link]
            bullet.changeDynamics(
                robot, i, jointLowerLimit=sheet.lower, jointUpperLimit=sheet.upper, physicsClientId=client
            )
    _set_friction(client, robot, number, body.shapes.shell_friction)
    pairs = _set_collisions(client, robot, number, body)
    _couple_hips(client, robot, number["LHipYawPitch"], number["RHipYawPitch"])
    return BulletModel(
        client=client,
        robot=robot,
        joints=names,
        numbers=tuple(number[name] for name in names),
        feet={side: number[link] for side, link in FOOT_LINKS.items()},
        pads={side: number[link + _PAD] for side, link in FOOT_LINKS.items()},
        sole_area=sole_area(body),
        pairs=pairs,
        masses=(torso.mass, *(body.links[name].mass for name in names)),
        torso_com=torso.com,
        torso_principal=inertias[TORSO].orientation,
    )


def _create_multibody(
    client: int,
    body: Body,
    number: Mapping[str, int],
    shapes: Mapping[str, tuple[int, int]],
    inertias: Mapping[str, PrincipalInertia],
    fixed: bool,
) -> int:
    """PyBullet's number of the robot with links, joints and shapes; its call takes a list per property.

    Args:
        client: Physics client.
        body: Data sheet.
        number: PyBullet's number of the torso and of each link, in the order of the links.
        shapes: Collision and visual shape numbers of links that have them.
        inertias: Of torso and links; a pad has none.
        fixed: Nail the torso to the world.
    """
    tree, torso = joint_tree(body), body.links[TORSO]
    links = [link for link in number if link != TORSO]
    none = (_NO_SHAPE, _NO_SHAPE)
    return int(
        bullet.createMultiBody(
            baseMass=0.0 if fixed else torso.mass,
            baseCollisionShapeIndex=shapes[TORSO][0],
            baseVisualShapeIndex=shapes[TORSO][1],
            baseInertialFramePosition=torso.com,
            baseInertialFrameOrientation=inertias[TORSO].orientation,
            linkMasses=[body.links[link].mass if link in tree else _NO_MASS for link in links],
            linkCollisionShapeIndices=[shapes.get(link, none)[0] for link in links],
            linkVisualShapeIndices=[shapes.get(link, none)[1] for link in links],
            linkPositions=[tree[link].offset if link in tree else _HERE for link in links],
            linkOrientations=[_UPRIGHT] * len(links),
            linkInertialFramePositions=[body.links[link].com if link in tree else _HERE for link in links],
            linkInertialFrameOrientations=[inertias.get(link, _NO_INERTIA).orientation for link in links],
            # PyBullet counts parents from the torso
            linkParentIndices=[
                number[tree[link].parent if link in tree else link.removesuffix(_PAD)] + 1 for link in links
            ],
            linkJointTypes=[bullet.JOINT_REVOLUTE if link in tree else bullet.JOINT_FIXED for link in links],
            linkJointAxis=[tree[link].axis if link in tree else _HERE for link in links],
            flags=bullet.URDF_USE_SELF_COLLISION,
            physicsClientId=client,
        )
    )


def _set_dynamics(client: int, robot: int, link: int, inertia: PrincipalInertia) -> None:
    """Exact inertia, and none of PyBullet's default damping: the servo brakes the joints.

    The inertia needs a call of its own: given together with damping, PyBullet 3.2.7 silently
    writes a link's inertia to the base.
    """
    bullet.changeDynamics(robot, link, localInertiaDiagonal=inertia.moments, physicsClientId=client)
    bullet.changeDynamics(
        robot,
        link,
        linearDamping=0.0,
        angularDamping=0.0,
        jointDamping=0.0,
        restitution=0.0,
        physicsClientId=client,
    )


def _set_friction(client: int, robot: int, number: Mapping[str, int], shell: float) -> None:
    """Coefficients of soles (1) and shell.

    PyBullet multiplies those of both partners: with a sole, the floor's alone is the pair's.
    """
    for name, link in number.items():
        sole = name.removesuffix(_PAD) in FOOT_LINKS.values()
        bullet.changeDynamics(robot, link, lateralFriction=1.0 if sole else shell, physicsClientId=client)


def _set_collisions(
    client: int, robot: int, number: Mapping[str, int], body: Body
) -> tuple[tuple[int, int], ...]:
    """Enable contact of the limbs that can touch (`collision_pairs`) alone; the pairs by PyBullet's numbers."""
    shapes, meeting = link_shapes(body), collision_pairs(body)
    shaped = [name for name in number if name in shapes or name.endswith(_PAD)]
    pairs = []
    for first, second in itertools.combinations(shaped, 2):
        meet = (first, second) in meeting or (second, first) in meeting
        i, j = number[first], number[second]
        bullet.setCollisionFilterPair(robot, robot, i, j, int(meet), physicsClientId=client)
        if meet:
            pairs.append((i, j))
    return tuple(pairs)


def _couple_hips(client: int, robot: int, left: int, right: int) -> None:
    """Gear the two HipYawPitch joints together: one motor turns both by the same angle."""
    gear = bullet.createConstraint(
        robot, left, robot, right, bullet.JOINT_GEAR, (1.0, 0.0, 0.0), _HERE, _HERE, physicsClientId=client
    )
    bullet.changeConstraint(gear, gearRatio=-1.0, maxForce=GEAR_TORQUE, erp=GEAR_ERP, physicsClientId=client)
