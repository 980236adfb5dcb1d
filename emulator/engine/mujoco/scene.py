"""Floor and objects in MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from bridge.body import Body
from bridge.types import Array, Quaternion, Vec3
from emulator.engine.base import Scene
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
from emulator.engine.mujoco.simulation import Simulation
from emulator.engine.values import Surface
from emulator.poses import ORIGIN, Pose, compose, matrix

FLOOR: Final = "floor"
"""Body of the floor and of all that is fixed on it."""
_HEIGHTFIELD_DEPTH: Final = 0.05
"""Depth of a heightfield's base, m."""


@dataclass
class _Object:
    """A thing in the scene."""

    pose: Pose
    """Pose when added: fixed things in the floor frame, others in the world."""
    body: Any = None
    """MuJoCo's description of a movable body; None: fixed on the floor."""
    geoms: tuple[Any, ...] = ()
    """For soles, for the shell, and of movable bodies for the ground."""
    friction: float | None = None
    """Its own; None: the floor's."""


class MujocoScene(Scene):
    """Floor and objects of a simulation.

    The floor is a body without mass, which is put anywhere; everything fixed on it belongs to that body.

    Args:
        simulation: An empty one.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation, self._step = simulation, simulation.settings.step
        self._friction, self._shell, self._floor = 1.0, 1.0, ORIGIN
        self._surface: Surface | None = None
        self._body: Body | None = None
        simulation.tune = self._soften
        self._objects: dict[str, _Object] = {}
        self.normal: Vec3 = (0.0, 0.0, 1.0)
        """Of the floor, world frame."""
        self._floor_body = simulation.spec.worldbody.add_body(name=FLOOR, mocap=True)
        plane = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": (0.0, 0.0, 1.0)}
        self._objects[FLOOR] = _Object(ORIGIN, None, self._add(self._floor_body, "plane", **plane))
        self._set_frictions()

    def _add(self, body: Any, kind: str, *, mass: float = 0.0, **options: Any) -> tuple[Any, ...]:
        """Give a body a shape, once for each kind of thing that it can touch."""
        group = OBJECT_GROUP if kind == "object" else GROUND_GROUP
        others = ("for the shell", "object") if kind == "object" else ("for the shell",)
        soles = contact_options(f"{kind} for soles", self._step)
        geoms = [body.add_geom(name=options.pop("name", ""), group=group, mass=mass, **options, **soles)]
        for other in others:
            rest = contact_options(other, self._step)
            geoms.append(body.add_geom(group=HIDDEN_GROUP, mass=0.0, **options, **rest))
        return tuple(geoms)

    def _set_frictions(self) -> None:
        for thing in self._objects.values():
            friction = self._friction if thing.friction is None else thing.friction
            for geom, fraction in zip(thing.geoms, (1.0, self._shell, 1.0), strict=False):
                geom.friction = (fraction * friction, 0.0, 0.0)
        self._simulation.changed()

    def set_robot(self, body: Body) -> None:
        """Enable contact of a robot's soles and shell with the surface."""
        self._body, self._shell = body, body.shapes.shell_friction
        self._set_frictions()

    def _soften(self, model: Any) -> None:
        """Give the soles of a newly compiled model the springs of the surface."""
        if self._body is not None and self._surface is not None:
            soften_soles(model, self._body, self._surface)

    def place_floor(self, pose: Pose, velocity: Vec3 = (0.0, 0.0, 0.0), spin: Vec3 = (0.0, 0.0, 0.0)) -> None:
        """See `Scene`. Known weakness: the velocities are not used; contacts follow the pose of each step."""
        self._floor = pose
        turn = matrix(pose.orientation)
        self.normal = (turn[2], turn[5], turn[8])
        data = self._simulation.data
        data.mocap_pos[0], data.mocap_quat[0] = pose.position, wxyz(pose.orientation)
        # a new compilation begins from the description
        self._floor_body.pos, self._floor_body.quat = pose.position, wxyz(pose.orientation)
        self._simulation.moved()

    def set_surface(self, surface: Surface) -> None:
        """See `Scene`."""
        self._surface, self._friction = surface, surface.friction
        self._set_frictions()

    def add_box(
        self, name: str, size: Vec3, pose: Pose, *, mass: float = 0.0, friction: float | None = None
    ) -> None:
        """See `Scene`."""
        box = {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": tuple(0.5 * edge for edge in size), "name": name}
        body = None
        if mass > 0.0:
            pose = compose(self._floor, pose)
            world = self._simulation.spec.worldbody
            body = world.add_body(name=name, pos=pose.position, quat=wxyz(pose.orientation))
            body.add_freejoint(name=name)
            geoms = self._add(body, "object", mass=mass, **box)
        else:
            geoms = self._fix(pose, **box)
        self._objects[name] = _Object(pose, body, geoms, friction)
        self._set_frictions()

    def _fix(self, pose: Pose, **options: Any) -> tuple[Any, ...]:
        return self._add(self._floor_body, "ground", pos=pose.position, quat=wxyz(pose.orientation), **options)

    def add_heightfield(self, name: str, heights: Array, spacing: float, at: Vec3) -> None:
        """See `Scene`."""
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
        pose = Pose((at[0], at[1], at[2] + low))
        geoms = self._fix(pose, type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname=name, name=name)
        self._objects[name] = _Object(pose, None, geoms)
        self._set_frictions()

    def add_pendulum(
        self, name: str, pivot: Pose, mass: float, length: float, radius: float, angle: float
    ) -> None:
        """See `Scene`."""
        body = self._simulation.spec.worldbody.add_body(
            name=name, pos=pivot.position, quat=wxyz(pivot.orientation)
        )
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0.0, 1.0, 0.0))
        ball = {"type": mujoco.mjtGeom.mjGEOM_SPHERE, "size": (radius, 0.0, 0.0)}
        geoms = self._add(body, "object", pos=(0.0, 0.0, -length), mass=mass, **ball)
        self._objects[name] = _Object(pivot, body, geoms)
        self._set_frictions()
        self._simulation.start_at(name, angle)

    def remove(self, name: str) -> None:
        """See `Scene`."""
        thing = self._objects.pop(name)
        spec = self._simulation.spec
        for gone in thing.geoms if thing.body is None else (thing.body,):
            spec.delete(gone)
        self._simulation.changed()

    @property
    def ground(self) -> int:
        """MuJoCo's number of the floor's body, which all that counts as ground belongs to."""
        return int(self._simulation.model.body(FLOOR).id)

    def geoms(self, name: str) -> list[int]:
        """MuJoCo's numbers of an object's geoms."""
        model, thing = self._simulation.model, self._objects[name]
        if thing.body is None:
            return [int(model.geom(name).id)]
        body = model.body(name)
        return [int(body.geomadr[0])]

    def pose(self, name: str) -> Pose:
        """See `Scene`."""
        thing = self._objects[name]
        if thing.body is None:
            return compose(self._floor, thing.pose)
        body = self._simulation.now.body(name)
        x, y, z = body.xpos.tolist()
        orientation: Quaternion = xyzw(body.xquat)
        return Pose((x, y, z), orientation)

    def velocity(self, name: str) -> tuple[Vec3, Vec3]:
        """See `Scene`."""
        if self._objects[name].body is None:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        data = self._simulation.now
        speed = data.joint(name).qvel
        vx, vy, vz = speed[:3].tolist()
        # MuJoCo's angular velocity of a free joint is in the body's frame
        wx, wy, wz = (data.body(name).xmat.reshape(3, 3) @ speed[3:]).tolist()
        return (vx, vy, vz), (wx, wy, wz)

    def move(self, name: str, pose: Pose, velocity: tuple[Vec3, Vec3]) -> None:
        """See `Scene`."""
        joint = self._simulation.data.joint(name)
        joint.qpos = (*pose.position, *wxyz(pose.orientation))
        turn = np.reshape(matrix(pose.orientation), (3, 3))
        joint.qvel = (*velocity[0], *(turn.T @ velocity[1]))
        self._simulation.moved()

    def push(self, name: str, force: Vec3) -> None:
        """See `Scene`."""
        self._simulation.data.body(name).xfrc_applied[:3] += force
