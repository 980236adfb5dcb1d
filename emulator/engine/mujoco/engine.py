"""MuJoCo behind the engine's interface, with its steps and rays in machine code."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import TORSO, Body
from bridge.errors import ConfigurationError
from bridge.types import Array
from emulator.compiled import compilable, compiled
from emulator.drives import DRIVE, Drives, run_drives, take_over
from emulator.engine.base import Engine, Multibody, Thing
from emulator.engine.contacts import Stops, brake_joints
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.contacts import MujocoContacts, add_contacts
from emulator.engine.mujoco.native import LAYOUT, Layout, mj_ray, mj_step
from emulator.engine.mujoco.picture import Painter
from emulator.engine.mujoco.robot import MujocoRobot
from emulator.engine.mujoco.scene import MujocoScene, MujocoThing
from emulator.engine.mujoco.shapes import GROUND_GROUP, OBJECT_GROUP, ROBOT_GROUP
from emulator.engine.mujoco.simulation import (
    MAX_ROBOTS,
    MujocoModel,
    Simulation,
    describe_robot,
    let_robots_touch,
)
from emulator.engine.settings import PhysicsSettings
from emulator.engine.values import PinholeCamera, RayHit, Surroundings, ThingShape
from emulator.poses import Pose

Places = NDArray[np.int64]
_MAX_INNER_SURFACES: Final = 8
"""Surfaces that a ray leaves from inside before it is given up."""
MAX_CONTACT_DISTANCE: Final = 0.001
"""Distance up to which MuJoCo reports two things as touching, m."""
_RAY_RESTART: Final = 1e-6
"""Distance behind a surface at which a ray continues, as a fraction of its length."""


@partial(compiled, nogil=True)
def run_steps(
    first: int,
    steps: int,
    changes: Places,
    ends: Places,
    drives: NDArray[Any],
    further: Array,
    model: int,
    data: int,
    layout: Layout,
    angles: Places,
    dofs: Places,
    qpos: Array,
    qvel: Array,
    force: Array,
    pushes: Array,
    stops: tuple[Array, Array, Array, float],
    contacts: tuple[NDArray[Any], ...],
) -> tuple[Array, Array]:
    """Run steps.

    Args:
        first: Number of the first one.
        steps: Number after the last one.
        changes: Step before which the drives of each robot take over their next request; -1: none.
        ends: Places in the drives at which one robot ends and the next one begins, (robots + 1,).
        drives: Of `emulator.drives.DRIVE`, of all joints of all robots, (n,).
        further: Torque on each joint besides the drives', (n,), N m.
        model: Address of MuJoCo's model.
        data: Address of its state.
        layout: `native.LAYOUT`.
        angles: Places of the joints in `qpos`, (n,).
        dofs: Places of the joints in `qvel` and `force`, (n,).
        qpos: MuJoCo's positions.
        qvel: MuJoCo's velocities.
        force: MuJoCo's applied torques.
        pushes: MuJoCo's applied forces of bodies, (bodies, 6); they act in the first step.
        stops: `Stops.constants`.
        contacts: `MujocoContacts.arrays`, to which those of the steps are added.

    Returns:
        Positions and velocities of the joints after them, (n,), rad and rad/s.
    """
    position, velocity, torque = np.empty(len(angles)), np.empty(len(angles)), np.empty(len(angles))
    _read_joints(angles, dofs, qpos, qvel, position, velocity)
    for step in range(first, steps):
        for robot in range(len(changes)):
            if step == changes[robot]:
                take_over(drives[ends[robot] : ends[robot + 1]])
        run_drives(drives, position, velocity, torque)
        for i in range(len(angles)):
            torque[i] += further[i]
        brake_joints(*stops, position, velocity, torque)
        for i in range(len(angles)):
            force[dofs[i]] = torque[i]
        mj_step(model, data)
        pushes.fill(0.0)
        add_contacts(data, layout, *contacts)
        _read_joints(angles, dofs, qpos, qvel, position, velocity)
    return position, velocity


@compilable
def _read_joints(
    angles: Places, dofs: Places, qpos: Array, qvel: Array, position: Array, velocity: Array
) -> None:
    for i in range(len(angles)):
        position[i], velocity[i] = qpos[angles[i]], qvel[dofs[i]]


def hits(
    simulation: Simulation, robots: Sequence[MujocoRobot], starts: Array, ends: Array, seen: Sequence[int]
) -> list[RayHit]:
    """The first surface that each ray hits from outside.

    Args:
        simulation: The world.
        robots: In it.
        starts: World frame, (n, 3), m.
        ends: One for each start, likewise.
        seen: Groups of the geoms that stop a ray.
    """
    groups = np.zeros(6, dtype=np.uint8)
    groups[list(seen)] = 1
    geoms, found = np.full(len(starts), -1, dtype=np.int32), np.zeros((len(starts), 7))
    model, data = simulation.model, simulation.now
    _cast(model._address, data._address, groups, starts, ends, geoms, found)
    result = []
    roots = {robot.bodies[TORSO]: robot for robot in robots}
    bodies = model.body_rootid[model.geom_bodyid[geoms]].tolist()
    for geom, body, end, hit in zip(geoms.tolist(), bodies, ends.tolist(), found.tolist(), strict=True):
        fraction, x, y, z, nx, ny, nz = hit
        if geom < 0:
            result.append(RayHit("nothing", None, 1.0, (end[0], end[1], end[2]), (0.0, 0.0, 0.0)))
        else:
            robot = roots.get(body)
            kind: Literal["scene", "robot"] = "scene" if robot is None else "robot"
            result.append(RayHit(kind, robot, fraction, (x, y, z), (nx, ny, nz)))
    return result


@partial(compiled, nogil=True)
def _cast(
    model: int,
    data: int,
    groups: NDArray[np.uint8],
    starts: Array,
    ends: Array,
    geoms: NDArray[np.int32],
    found: Array,
) -> None:
    # `found`: fraction of the way, point, normal
    geom, normal, way, begin = np.zeros(1, dtype=np.int32), np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(len(starts)):
        gone = 0.0
        for axis in range(3):
            way[axis] = ends[i, axis] - starts[i, axis]
        for _ in range(_MAX_INNER_SURFACES):
            for axis in range(3):
                begin[axis] = starts[i, axis] + gone * way[axis]
            places = (
                begin.ctypes.data,
                way.ctypes.data,
                groups.ctypes.data,
                geom.ctypes.data,
                normal.ctypes.data,
            )
            far = mj_ray(model, data, places[0], places[1], places[2], 1, -1, places[3], places[4])
            if far < 0.0 or gone + far > 1.0:
                break
            gone += far
            if normal[0] * way[0] + normal[1] * way[1] + normal[2] * way[2] < 0.0:
                geoms[i] = geom[0]
                found[i, 0] = gone
                for axis in range(3):
                    found[i, 1 + axis] = starts[i, axis] + gone * way[axis]
                    found[i, 4 + axis] = normal[axis]
                break
            gone += _RAY_RESTART  # it left a shape from inside


class MujocoEngine(Engine):
    """A simulation with a floor and robots.

    Args:
        settings: Of the physics.
    """

    robots: list[MujocoRobot]  # type: ignore[assignment]

    def __init__(self, settings: PhysicsSettings) -> None:
        super().__init__(settings)
        self.simulation = Simulation(settings)
        """MuJoCo's own description, model and data; for tests that ask MuJoCo itself."""
        self._painter = Painter()
        self._scene = MujocoScene(self.simulation)
        self._descriptions: list[MujocoModel] = []
        self._prepare()

    def _prepare(self) -> None:
        """Lay out the memory of the robots there are."""
        robots = self.robots
        self._contacts = MujocoContacts(self.simulation, robots, self._scene)
        self._ends = np.cumsum([0, *(len(robot.joints) for robot in robots)])
        self._drives, self._further = np.zeros(self._ends[-1], DRIVE), np.zeros(self._ends[-1])
        for robot, begin, end in zip(robots, self._ends, self._ends[1:], strict=False):
            robot.drives.move(self._drives[begin:end])
            self._further[begin:end] = robot.torque
            robot.torque = self._further[begin:end]
        step = self.settings.step
        stops: list[tuple[Any, ...]] = [
            Stops(robot.body, robot.joints, robot.drives.rotor_inertia, step).constants for robot in robots
        ]
        lower, upper, torque_per_way = (_joined([each[i] for each in stops]) for i in range(3))
        self._stops = (lower, upper, torque_per_way, step)
        self._version = -1

    def surround(self, surroundings: Surroundings) -> None:
        """See `Engine`."""
        self.surroundings = surroundings
        self._scene.surround(surroundings)

    def add(self, shape: ThingShape, pose: Pose) -> Thing:
        """See `Engine`."""
        return self._scene.add(shape, pose)

    def add_robot(self, body: Body, drives: Drives, *, held: bool = False) -> Multibody:
        """See `Engine`."""
        if len(self.robots) == MAX_ROBOTS:
            raise ConfigurationError(f"A world of MuJoCo holds {MAX_ROBOTS} robots at most.")
        prefix = f"{len(self.robots) + 1}/"
        description = describe_robot(self.simulation, body, drives.rotor_inertia, held=held, prefix=prefix)
        self._scene.add_robot(description)
        self._descriptions.append(description)
        if len(self._descriptions) > 1:
            let_robots_touch(self._descriptions, self.settings.step)
        robot = MujocoRobot(description, self.simulation, drives)
        self.robots.append(robot)
        self._prepare()
        return robot

    def remove(self, thing: Thing) -> None:
        """See `Engine`."""
        assert isinstance(thing, MujocoThing)
        self._scene.remove(thing)

    def run(self, steps: int, before_step: Callable[[], None] | None = None) -> None:
        """See `Engine`."""
        self._contacts.begin()
        if before_step is None:
            self._run(0, steps)
        else:
            for step in range(steps):
                before_step()
                self._run(step, step + 1)
        for robot in self.robots:
            robot.read_lock()
        self._contacts.give(steps)

    def _run(self, first: int, steps: int) -> None:
        simulation, robots = self.simulation, self.robots
        model, data = simulation.model, simulation.data
        if self._version != simulation.version:
            self._version = simulation.version
            for robot in robots:
                robot.find()
            self._arguments = (
                model._address,
                data._address,
                LAYOUT,
                _joined([robot.angles for robot in robots], np.int64),
                _joined([robot.dofs for robot in robots], np.int64),
                data.qpos,
                data.qvel,
                data.qfrc_applied,
                data.xfrc_applied,
                self._stops,
                self._contacts.arrays(),
            )
        changes = np.array([robot.drives.change for robot in robots], dtype=np.int64)
        position, velocity = run_steps(
            first, steps, changes, self._ends, self._drives, self._further, *self._arguments
        )
        for robot, begin, end in zip(robots, self._ends, self._ends[1:], strict=False):
            robot.position, robot.velocity = position[begin:end], velocity[begin:end]
        simulation.moved()

    def rays(self, starts: ArrayLike, ends: ArrayLike, *, ground_only: bool = False) -> list[RayHit]:
        """See `Engine`."""
        seen = [GROUND_GROUP] if ground_only else [GROUND_GROUP, ROBOT_GROUP, OBJECT_GROUP]
        ways = np.asarray(starts, dtype=float), np.asarray(ends, dtype=float)
        return hits(self.simulation, self.robots, *ways, seen)

    def overlap(self, robot: Multibody, other: Thing) -> float:
        """See `Engine`."""
        assert isinstance(robot, MujocoRobot)
        model, data = self.simulation.model, self.simulation.now
        robot.find()
        pairs: Iterable[tuple[int, int]] = robot.pairs
        if isinstance(other, MujocoThing):
            pairs = itertools.product(robot.geoms, [other.geom])
        elif isinstance(other, MujocoRobot) and other is not robot:
            other.find()
            pairs = itertools.product(robot.geoms, other.geoms)
        reach = MAX_CONTACT_DISTANCE
        depths = (-float(mujoco.mj_geomDistance(model, data, a, b, reach, None)) for a, b in pairs)
        return max(0.0, max(depths, default=0.0))

    def picture(self, camera: PinholeCamera) -> NDArray[np.uint8]:
        """See `Engine`."""
        return self._painter.draw(self.simulation.model, self.simulation.now, camera)

    def close(self) -> None:
        """Free what pictures are drawn with; harmless when called twice."""
        self._painter.close()


def _joined(parts: Sequence[NDArray[Any]], dtype: Any = np.float64) -> NDArray[Any]:
    return np.concatenate([np.zeros(0, dtype), *parts])
