"""Floor and objects in MuJoCo."""

from __future__ import annotations

import itertools
from typing import Any, Final

import numpy as np

from bridge.types import Vec3
from emulator.engine.base import AT_REST, Thing
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.shapes import (
    GROUND_GROUP,
    HIDDEN_GROUP,
    OBJECT_GROUP,
    contact_options,
    soften_soles,
    wxyz,
    xyzw,
)
from emulator.engine.mujoco.simulation import MujocoModel, Simulation
from emulator.engine.values import (
    Ball,
    BodyState,
    Box,
    HeightField,
    Pendulum,
    Pole,
    Surface,
    Surroundings,
    ThingShape,
)
from emulator.poses import ORIGIN, Pose, compose, matrix

FLOOR: Final = "floor"
"""Body of the floor and of all that is fixed on it."""
_HEIGHTFIELD_DEPTH: Final = 0.05
"""Depth of a heightfield's base, m."""


class MujocoThing(Thing):
    """An object of a simulation.

    Args:
        simulation: With the object.
        name: Of its body, or of its geom on the floor.
        pose: When added: fixed things in the floor frame, others in the world.
        body: MuJoCo's description of a body of its own; None: fixed on the floor.
        geoms: For soles, for the shell, and of movable bodies for the ground.
        friction: Its own coefficient; None: the floor's.
    """

    def __init__(
        self,
        simulation: Simulation,
        name: str,
        pose: Pose,
        body: Any,
        geoms: tuple[Any, ...],
        friction: float | None = None,
    ) -> None:
        self.rolling_arm = 0.0
        """Lever of a ball's rolling friction, m."""
        self._simulation, self.name, self.pose = simulation, name, pose
        self.body, self.geoms, self.friction = body, geoms, friction

    @property
    def geom(self) -> int:
        """MuJoCo's number of its first geom."""
        model = self._simulation.model
        return int(model.geom(self.name).id if self.body is None else model.body(self.name).geomadr[0])

    def state(self) -> BodyState:
        """See `Thing`."""
        data = self._simulation.now
        if self.body is None:
            position, turn = compose(self.pose_of_floor(data), self.pose)
            return BodyState(position, turn, matrix(turn), AT_REST, AT_REST)
        body, velocity = data.body(self.name), np.zeros(6)
        if len(speed := data.joint(self.name).qvel) == 6:
            # MuJoCo's angular velocity of a free joint is in the body's frame
            velocity[:3], velocity[3:] = speed[:3], body.xmat.reshape(3, 3) @ speed[3:]
        x, y, z = body.xpos.tolist()
        vx, vy, vz, wx, wy, wz = velocity.tolist()
        turn = xyzw(body.xquat)
        return BodyState((x, y, z), turn, matrix(turn), (vx, vy, vz), (wx, wy, wz))

    @staticmethod
    def pose_of_floor(data: Any) -> Pose:
        """Floor's pose of the state `data`."""
        x, y, z = data.mocap_pos[0].tolist()
        return Pose((x, y, z), xyzw(data.mocap_quat[0]))

    def place(self, pose: Pose, velocity: Vec3 = AT_REST, spin: Vec3 = AT_REST) -> None:
        """See `Thing`."""
        joint = self._simulation.data.joint(self.name)
        joint.qpos = (*pose.position, *wxyz(pose.orientation))
        turn = np.reshape(matrix(pose.orientation), (3, 3))
        joint.qvel = (*velocity, *(turn.T @ spin))
        self._simulation.moved()

    def push(self, force: Vec3) -> None:
        """See `Thing`."""
        self._simulation.data.body(self.name).xfrc_applied[:3] += force


class MujocoScene:
    """Floor and objects of a simulation.

    The floor is a body without mass, which is put anywhere; everything fixed on it belongs to that body.

    Args:
        simulation: An empty one.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation, self._step = simulation, simulation.settings.step
        self._friction, self._shell, self._floor = 1.0, 1.0, ORIGIN
        self._surface: Surface | None = None
        self._robots: list[MujocoModel] = []
        simulation.tune = self._soften
        self._numbers = itertools.count(1)
        self.normal: Vec3 = (0.0, 0.0, 1.0)
        """Normal of the floor, world frame."""
        self._floor_body = simulation.spec.worldbody.add_body(name=FLOOR, mocap=True)
        plane = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": (0.0, 0.0, 1.0)}
        geoms = self._add(self._floor_body, "plane", **plane)
        self._things = [MujocoThing(simulation, FLOOR, ORIGIN, None, geoms)]
        self._set_frictions()

    def _add(self, body: Any, kind: str, *, mass: float = 0.0, **options: Any) -> tuple[Any, ...]:
        """Give a body a shape, once for each kind of thing that it can touch."""
        movable = kind in ("object", "ball")
        group = OBJECT_GROUP if movable else GROUND_GROUP
        others = ("for the shell", kind) if movable else ("for the shell",)
        soles = contact_options("object for soles" if movable else f"{kind} for soles", self._step)
        geoms = [body.add_geom(name=options.pop("name", ""), group=group, mass=mass, **options, **soles)]
        for other in others:
            rest = contact_options(other, self._step)
            geoms.append(body.add_geom(group=HIDDEN_GROUP, mass=0.0, **options, **rest))
        return tuple(geoms)

    def _set_frictions(self) -> None:
        for thing in self._things:
            friction = self._friction if thing.friction is None else thing.friction
            for geom, fraction in zip(thing.geoms, (1.0, self._shell, 1.0), strict=False):
                geom.friction = (fraction * friction, 0.0, 0.0)
            if thing.rolling_arm > 0.0:
                thing.geoms[-1].friction = (friction, 0.0, thing.rolling_arm)
        self._simulation.changed()

    def add_robot(self, robot: MujocoModel) -> None:
        """Enable contact of a robot's soles and shell with the surface."""
        self._robots.append(robot)
        self._shell = robot.body.shapes.shell_friction
        self._set_frictions()

    def _soften(self, model: Any) -> None:
        """Give the soles of a newly compiled model the springs of the surface."""
        if self._surface is not None:
            for robot in self._robots:
                soften_soles(model, robot.body, self._surface, robot.prefix)

    def surround(self, new: Surroundings) -> None:
        """Place the floor, and set its surface and gravity, where they change.

        Known weakness: the floor's velocities are not used; contacts follow the pose of each step.
        """
        self._simulation.set_gravity(new.gravity)
        if new.surface is not None and new.surface is not self._surface:
            self._surface, self._friction = new.surface, new.surface.friction
            self._set_frictions()
        if new.floor != self._floor:
            self._floor, self.normal = new.floor, new.normal
            position, turn = new.floor.position, wxyz(new.floor.orientation)
            data = self._simulation.data
            data.mocap_pos[0], data.mocap_quat[0] = position, turn
            # a new compilation begins from the description
            self._floor_body.pos, self._floor_body.quat = position, turn
            self._simulation.moved()

    def add(self, shape: ThingShape, pose: Pose) -> MujocoThing:
        """See `Engine.add`."""
        name = f"thing {next(self._numbers)}"
        if isinstance(shape, Ball):
            thing = self._add_ball(name, shape, pose)
        elif isinstance(shape, Box | Pole):
            thing = self._add_solid(name, shape, pose)
        elif isinstance(shape, HeightField):
            thing = self._add_heightfield(name, shape, pose)
        else:
            thing = self._add_pendulum(name, shape, pose)
        self._things.append(thing)
        self._set_frictions()
        return thing

    def _add_ball(self, name: str, ball: Ball, pose: Pose) -> MujocoThing:
        sphere = {"type": mujoco.mjtGeom.mjGEOM_SPHERE, "size": (ball.radius, 0.0, 0.0)}
        thing = self._add_movable(name, "ball", ball.mass, pose, ball.friction, **sphere)
        thing.rolling_arm = ball.rolling_arm(self._simulation.settings.gravity)
        return thing

    def _add_solid(self, name: str, shape: Box | Pole, pose: Pose) -> MujocoThing:
        if isinstance(shape, Pole):
            size: Vec3 = (shape.radius, 0.5 * shape.height, 0.0)
            solid = {"type": mujoco.mjtGeom.mjGEOM_CYLINDER, "size": size}
        else:
            x, y, z = shape.size
            solid = {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": (0.5 * x, 0.5 * y, 0.5 * z)}
        if shape.mass > 0.0:
            return self._add_movable(name, "object", shape.mass, pose, shape.friction, **solid)
        geoms = self._fix(pose, name=name, **solid)
        return MujocoThing(self._simulation, name, pose, None, geoms, shape.friction)

    def _add_movable(
        self, name: str, kind: str, mass: float, pose: Pose, friction: float | None, **options: Any
    ) -> MujocoThing:
        pose = compose(self._floor, pose)
        world = self._simulation.spec.worldbody
        body = world.add_body(name=name, pos=pose.position, quat=wxyz(pose.orientation))
        body.add_freejoint(name=name)
        geoms = self._add(body, kind, mass=mass, name=name, **options)
        return MujocoThing(self._simulation, name, pose, body, geoms, friction)

    def _fix(self, pose: Pose, **options: Any) -> tuple[Any, ...]:
        return self._add(self._floor_body, "ground", pos=pose.position, quat=wxyz(pose.orientation), **options)

    def _add_heightfield(self, name: str, field: HeightField, pose: Pose) -> MujocoThing:
        heights, spacing = field.heights, field.spacing
        rows, columns = heights.shape
        low = float(heights.min())
        span = max(float(heights.max()) - low, 1e-6)
        self._simulation.spec.add_hfield(
            name=name,
            nrow=rows,
            ncol=columns,
            size=(0.5 * spacing * (columns - 1), 0.5 * spacing * (rows - 1), span, _HEIGHTFIELD_DEPTH),
            userdata=((heights - low) / span).ravel().tolist(),
        )
        x, y, z = pose.position
        pose = Pose((x, y, z + low), pose.orientation)
        geoms = self._fix(pose, type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname=name, name=name)
        return MujocoThing(self._simulation, name, pose, None, geoms)

    def _add_pendulum(self, name: str, pendulum: Pendulum, pivot: Pose) -> MujocoThing:
        body = self._simulation.spec.worldbody.add_body(
            name=name, pos=pivot.position, quat=wxyz(pivot.orientation)
        )
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0.0, 1.0, 0.0))
        ball = {"type": mujoco.mjtGeom.mjGEOM_SPHERE, "size": (pendulum.radius, 0.0, 0.0)}
        geoms = self._add(body, "object", pos=(0.0, 0.0, -pendulum.length), mass=pendulum.mass, **ball)
        self._simulation.start_at(name, pendulum.angle)
        return MujocoThing(self._simulation, name, pivot, body, geoms)

    def remove(self, thing: MujocoThing) -> None:
        """See `Engine.remove`."""
        self._things.remove(thing)
        for gone in thing.geoms if thing.body is None else (thing.body,):
            self._simulation.spec.delete(gone)
        self._simulation.changed()

    @property
    def ground(self) -> int:
        """MuJoCo's number of the floor's body, which all that counts as ground belongs to."""
        return int(self._simulation.model.body(FLOOR).id)
