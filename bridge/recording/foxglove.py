"""Robot and objects in Foxglove's 3-D panel, in its own schemas: transforms, joint states, scene and URDF.

Source: docs.foxglove.dev, schemas `FrameTransforms`, `JointStates`, `SceneUpdate`, `RobotDescription`.
They follow from the messages of the contract; readers of recordings pass them over.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR, TORSO
from bridge.body.kinematics import LinkTransform, LinkTransforms
from bridge.body.sole import sole_outline
from bridge.messages import SensorFrame, TruthFrame, WalkTelemetry
from bridge.messages.world_state import WorldObject
from bridge.rotations import R_yaw, heading, matrix, quaternion
from bridge.types import SIDES, Side, Vec3
from bridge.types import Quaternion as UnitQuaternion

WORLD: Final = "world"
_FOOTPRINT: Final = "base_footprint"
MESSAGE_CYCLES: Final = 5
"""Cycles from one message to the next: 20 a second, and on a V6 17."""
_LOADED_FORCE: Final = 5.0
"""Force on a loaded foot, N."""
_MIN_STEP: Final = 0.02
"""m from the last footprint of a foot"""
_THICKNESS: Final = 0.002
"""m of a footprint"""


class Time(msgspec.Struct):
    """Robot time."""

    sec: int
    nsec: int


class Vector3(msgspec.Struct):
    """A place or a size, m."""

    x: float
    y: float
    z: float


class Quaternion(msgspec.Struct):
    """A rotation."""

    x: float
    y: float
    z: float
    w: float


class FrameTransform(msgspec.Struct):
    """A child's frame in its parent's."""

    timestamp: Time
    parent_frame_id: str
    child_frame_id: str
    translation: Vector3
    rotation: Quaternion


class FrameTransforms(msgspec.Struct):
    """`foxglove.FrameTransforms`."""

    transforms: tuple[FrameTransform, ...]


class JointState(msgspec.Struct):
    """One joint."""

    name: str
    position: float


class JointStates(msgspec.Struct):
    """`foxglove.JointStates`."""

    timestamp: Time
    joints: tuple[JointState, ...]


class RobotDescription(msgspec.Struct):
    """`foxglove.RobotDescription`; `data` in base64."""

    data: str
    format: str = "urdf"
    url: str = ""


class Pose(msgspec.Struct):
    """A place and a rotation."""

    position: Vector3
    orientation: Quaternion


class Color(msgspec.Struct):
    """Shares of red, green and blue, and opacity."""

    r: float
    g: float
    b: float
    a: float


class Cube(msgspec.Struct):
    """A box about the middle of its pose."""

    pose: Pose
    size: Vector3
    color: Color


class Sphere(msgspec.Struct):
    """A ball in a box about the middle of its pose."""

    pose: Pose
    size: Vector3
    color: Color


class Cylinder(msgspec.Struct):
    """A cylinder along z in a box about the middle of its pose."""

    pose: Pose
    size: Vector3
    color: Color
    bottom_scale: float = 1.0
    top_scale: float = 1.0


class Nothing(msgspec.Struct):
    """An item of the lists that stay empty here."""


class Entity(msgspec.Struct):
    """One visible thing."""

    timestamp: Time
    frame_id: str
    id: str
    lifetime: Time
    """Without an update; 0: it stays until the end."""
    cubes: tuple[Cube, ...] = ()
    spheres: tuple[Sphere, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()
    frame_locked: bool = False
    metadata: tuple[Nothing, ...] = ()
    arrows: tuple[Nothing, ...] = ()
    lines: tuple[Nothing, ...] = ()
    triangles: tuple[Nothing, ...] = ()
    texts: tuple[Nothing, ...] = ()
    models: tuple[Nothing, ...] = ()


class SceneUpdate(msgspec.Struct):
    """`foxglove.SceneUpdate`."""

    entities: tuple[Entity, ...]
    deletions: tuple[Nothing, ...] = ()


Shown = FrameTransforms | JointStates | RobotDescription | SceneUpdate
SHOWN: Final[dict[type[Shown], str]] = {
    FrameTransforms: "3d/transforms",
    JointStates: "3d/joint_states",
    SceneUpdate: "3d/scene",
    RobotDescription: "3d/robot_description",
}
"""Topic of each kind of message."""
_SHOWN_TIME: Final = 200_000_000
"""ns for which an object is shown without an update: three messages."""
_WHITE, _WOOD = Color(0.92, 0.93, 0.92, 1.0), Color(0.83, 0.64, 0.36, 1.0)
_COLOURS: Final = {"L": Color(0.85, 0.37, 0.01, 0.8), "R": Color(0.12, 0.47, 0.71, 0.8)}


class RobotScene:
    """Follows one robot.

    The torso is where the ground truth has it; without one where the odometry has it.

    Args:
        body: data sheet.
        urdf: description of the robot; None: its links are not drawn.
    """

    def __init__(self, body: Body, urdf: str | None) -> None:
        self.body, self._links = body, LinkTransforms(body)
        self._urdf = urdf
        self._sole = (0.0, 0.0, -body.lengths.FootHeight)
        self._outline = {side: sole_outline(body, side) for side in SIDES}
        self._place: Vec3 = (0.0, 0.0, 0.0)
        self._frame: SensorFrame | None = None
        self._truth: TruthFrame | None = None
        self._was_loaded = dict.fromkeys(SIDES, False)
        self._footprints: dict[str, Vec3] = {}
        self._count = 0

    def add(self, message: object) -> Iterator[Shown]:
        """Take in the next message; at a sensor frame, the messages of an earlier one."""
        if isinstance(message, WalkTelemetry):
            self._place = message.place
        elif isinstance(message, TruthFrame):
            self._truth = message
        elif isinstance(message, SensorFrame):
            if self._urdf is not None:
                yield RobotDescription(data=base64.b64encode(self._urdf.encode()).decode())
                self._urdf = None
            if self._frame is not None:
                yield from self._show(self._frame)
            self._frame = message if message.seq % MESSAGE_CYCLES == 0 else None
            self._truth = None

    def _show(self, frame: SensorFrame) -> Iterator[Shown]:
        nanoseconds = round(1e9 * frame.time)
        stamp = Time(*divmod(nanoseconds, 1_000_000_000))
        truth = self._truth
        position = frame.position if truth is None else truth.joints
        transforms = [*self._torso(frame, truth), *self._links.of_joints(position)]
        yield FrameTransforms(tuple(_transform(stamp, one) for one in transforms))
        yield JointStates(
            stamp, tuple(JointState(name, position[INDEX_WITH_MIRROR[name]]) for name in self._links.joints)
        )
        made = [*self._footsteps(stamp, frame, transforms)]
        made += [_object(stamp, thing) for thing in (truth.objects if truth is not None else ())]
        if made:
            yield SceneUpdate(tuple(made))

    def _torso(self, frame: SensorFrame, truth: TruthFrame | None) -> list[LinkTransform]:
        if truth is not None:
            return [LinkTransform(WORLD, TORSO, truth.torso_position, truth.torso_orientation)]
        x, y, yaw = self._place
        return [
            LinkTransform(WORLD, _FOOTPRINT, (x, y, 0.0), quaternion(R_yaw(yaw))),
            self._links.torso_over_feet(_FOOTPRINT, frame.position, frame.angle),
        ]

    def _footsteps(
        self, stamp: Time, frame: SensorFrame, transforms: Sequence[LinkTransform]
    ) -> Iterator[Entity]:
        """Footsteps of the soles loaded at a new place."""
        by_child = {one.child: one for one in transforms}
        for i, side in enumerate(SIDES):
            loaded = sum(frame.fsr[4 * i : 4 * i + 4]) > _LOADED_FORCE
            was_loaded, self._was_loaded[side] = self._was_loaded[side], loaded
            if not (loaded and was_loaded):
                continue
            turn, sole = _placed(by_child, f"{side}AnkleRoll", self._sole)
            last = self._footprints.get(side)
            if last is not None and math.dist(sole, last) < _MIN_STEP:
                continue
            self._footprints[side] = sole
            self._count += 1
            yield self._footstep(stamp, side, heading(matrix(turn)), sole)

    def _footstep(self, stamp: Time, side: Side, yaw: float, sole: Vec3) -> Entity:
        low, high = self._outline[side].min(axis=0), self._outline[side].max(axis=0)
        turn = R_yaw(yaw)
        x, y, z = (np.array(sole) + turn @ [*(0.5 * (low + high)), 0.0]).tolist()
        pose = Pose(Vector3(x, y, z), Quaternion(*quaternion(turn)))
        length, width = (high - low).tolist()
        cube = Cube(pose, Vector3(length, width, _THICKNESS), _COLOURS[side])
        return Entity(stamp, WORLD, f"{side}{self._count}", Time(0, 0), (cube,))


def _object(stamp: Time, thing: WorldObject) -> Entity:
    pose = Pose(Vector3(*thing.position), Quaternion(*thing.orientation))
    entity = Entity(stamp, WORLD, f"object {thing.name}", Time(0, _SHOWN_TIME))
    size = Vector3(*thing.size)
    if thing.shape == "ball":
        entity.spheres = (Sphere(pose, size, _WHITE),)
    elif thing.shape == "pole":
        entity.cylinders = (Cylinder(pose, size, _WOOD),)
    else:
        entity.cubes = (Cube(pose, size, _WOOD),)
    return entity


def _transform(stamp: Time, one: LinkTransform) -> FrameTransform:
    return FrameTransform(stamp, one.parent, one.child, Vector3(*one.translation), Quaternion(*one.rotation))


def _placed(by_child: Mapping[str, LinkTransform], link: str, point: Vec3) -> tuple[UnitQuaternion, Vec3]:
    """A link's rotation and one of its points in the world's frame; plain numbers, as this runs in a cycle."""
    turn: UnitQuaternion = (0.0, 0.0, 0.0, 1.0)
    while link != WORLD:
        one = by_child[link]
        x, y, z = _rotated(one.rotation, point)
        a, b, c = one.translation
        point, turn, link = (x + a, y + b, z + c), _product(one.rotation, turn), one.parent
    return turn, point


def _product(p: UnitQuaternion, q: UnitQuaternion) -> UnitQuaternion:
    (a, b, c, d), (x, y, z, w) = p, q
    return (
        d * x + a * w + b * z - c * y,
        d * y - a * z + b * w + c * x,
        d * z + a * y - b * x + c * w,
        d * w - a * x - b * y - c * z,
    )


def _rotated(q: UnitQuaternion, point: Vec3) -> Vec3:
    (a, b, c, w), (x, y, z) = q, point
    u, v, t = 2.0 * (b * z - c * y), 2.0 * (c * x - a * z), 2.0 * (a * y - b * x)
    return x + w * u + b * t - c * v, y + w * v + c * u - a * t, z + w * t + a * v - b * u
