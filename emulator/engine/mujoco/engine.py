"""MuJoCo behind the engine's interface, with its steps and rays in machine code."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import Body
from bridge.types import Array, Vec3
from emulator.compiled import compilable, compiled
from emulator.drives import DRIVE, run_drives, take_over
from emulator.engine.base import Engine
from emulator.engine.contacts import Stops, brake_joints
from emulator.engine.mujoco.contacts import MujocoContacts, add_contacts
from emulator.engine.mujoco.native import LAYOUT, Layout, mj_ray, mj_step
from emulator.engine.mujoco.picture import Painter
from emulator.engine.mujoco.robot import MujocoRobot
from emulator.engine.mujoco.scene import MujocoScene
from emulator.engine.mujoco.shapes import GROUND_GROUP, OBJECT_GROUP, ROBOT_GROUP
from emulator.engine.mujoco.simulation import Simulation, describe_robot
from emulator.engine.values import GroundContacts, PhysicsSettings, PinholeCamera, RayHit

Places = NDArray[np.int64]
_MAX_INNER_SURFACES: Final = 8
"""Surfaces that a ray leaves from inside before it is given up."""
_RAY_RESTART: Final = 1e-6
"""Distance behind a surface at which a ray continues, as a fraction of its length."""
_NO_DRIVES: Final = np.zeros(0, DRIVE)


@partial(compiled, nogil=True)
def run_steps(
    steps: int,
    change: int,
    drives: NDArray[Any],
    torque: Array,
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
        steps: How many.
        change: Step, from 0, before which the drives take over their next request; -1: none.
        drives: Of `emulator.drives.DRIVE`, (n,); none of them: the torques are given.
        torque: Of the drives, (n,), N m; overwritten.
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
    position, velocity = np.empty(len(angles)), np.empty(len(angles))
    _read_joints(angles, dofs, qpos, qvel, position, velocity)
    for step in range(steps):
        if step == change:
            take_over(drives)
        if len(drives) > 0:
            run_drives(drives, position, velocity, torque)
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


def hits(simulation: Simulation, starts: Array, ends: Array, seen: Sequence[int]) -> list[RayHit]:
    """The first surface that each ray hits from outside.

    Args:
        simulation: The world.
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
    robots = (model.geom_group[geoms] == ROBOT_GROUP).tolist()
    for geom, robot, end, hit in zip(geoms.tolist(), robots, ends.tolist(), found.tolist(), strict=True):
        fraction, x, y, z, nx, ny, nz = hit
        if geom < 0:
            result.append(RayHit("nothing", 1.0, (end[0], end[1], end[2]), (0.0, 0.0, 0.0)))
        else:
            result.append(RayHit("robot" if robot else "scene", fraction, (x, y, z), (nx, ny, nz)))
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
    """A simulation with a floor and a robot.

    Args:
        settings: Of the physics.
    """

    robot: MujocoRobot
    scene: MujocoScene

    def __init__(self, settings: PhysicsSettings) -> None:
        self.settings = settings
        self._painter = Painter()
        self._begin()

    def _begin(self) -> None:
        self.simulation = Simulation(self.settings)
        """MuJoCo's own description, model and data; for tests that ask MuJoCo itself."""
        self.scene = MujocoScene(self.simulation)

    def add_robot(self, body: Body, rotor_inertia: Array, *, held: bool = False) -> None:
        """See `Engine`."""
        description = describe_robot(self.simulation, body, rotor_inertia, held=held)
        self.scene.set_robot(body)
        self.robot = MujocoRobot(description, self.simulation, self.scene)
        self._stops = Stops(body, self.robot.joints, rotor_inertia, self.settings.step)
        self._contacts = MujocoContacts(self.simulation, self.robot, self.scene)
        self._steps, self._version = 0, -1

    def begin_cycle(self) -> None:
        """See `Engine`."""
        self._contacts.begin()
        self._steps = 0

    def run(self, drives: NDArray[Any], steps: int, change: int) -> None:
        """See `Engine`."""
        self._run(drives, np.zeros(len(drives)), steps, change)

    def step(self, torque: Array) -> None:
        """See `Engine`."""
        self._run(_NO_DRIVES, torque, 1, -1)

    def _run(self, drives: NDArray[Any], torque: Array, steps: int, change: int) -> None:
        simulation, robot = self.simulation, self.robot
        model, data = simulation.model, simulation.data
        if self._version != simulation.version:
            self._version = simulation.version
            robot.find()
            addresses = model._address, data._address
            self._arguments = (
                *addresses,
                LAYOUT,
                *robot.arrays(),
                self._stops.constants,
                self._contacts.arrays(),
            )
        robot.position, robot.velocity = run_steps(steps, change, drives, torque, *self._arguments)
        self._steps += steps
        simulation.moved()

    def bare_step(self) -> None:
        """See `Engine`."""
        self.simulation.step()

    def contacts(self) -> GroundContacts:
        """See `Engine`."""
        return self._contacts.mean(self._steps)

    def set_gravity(self, gravity: Vec3) -> None:
        """See `Engine`."""
        self.simulation.set_gravity(gravity)

    def rays(self, starts: ArrayLike, ends: ArrayLike, *, ground_only: bool = False) -> list[RayHit]:
        """See `Engine`."""
        seen = [GROUND_GROUP] if ground_only else [GROUND_GROUP, ROBOT_GROUP, OBJECT_GROUP]
        return hits(self.simulation, np.asarray(starts, dtype=float), np.asarray(ends, dtype=float), seen)

    def picture(self, camera: PinholeCamera) -> NDArray[np.uint8]:
        """See `Engine`."""
        return self._painter.draw(self.simulation.model, self.simulation.now, camera)

    def reset(self) -> None:
        """See `Engine`."""
        self._begin()

    def close(self) -> None:
        """See `Engine`."""
        self._painter.close()
