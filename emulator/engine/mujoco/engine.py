"""MuJoCo behind the engine's interface."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import Body
from bridge.types import Vec3
from emulator.drives import DRIVE
from emulator.engine.base import Engine
from emulator.engine.mujoco.contacts import MujocoContacts
from emulator.engine.mujoco.model import describe_robot
from emulator.engine.mujoco.native import LAYOUT
from emulator.engine.mujoco.picture import Painter
from emulator.engine.mujoco.rays import hits
from emulator.engine.mujoco.robot import MujocoRobot
from emulator.engine.mujoco.scene import MujocoScene
from emulator.engine.mujoco.shapes import GROUND_GROUP, OBJECT_GROUP, ROBOT_GROUP
from emulator.engine.mujoco.simulation import Simulation
from emulator.engine.mujoco.steps import run_steps
from emulator.engine.multibody import Vector
from emulator.engine.stops import Stops
from emulator.engine.values import GroundContacts, PhysicsSettings, PinholeCamera, RayHit

_NO_DRIVES: Final = np.zeros(0, DRIVE)


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

    def add_robot(self, body: Body, rotor_inertia: Vector, *, held: bool = False) -> None:
        """See `Engine`."""
        description = describe_robot(self.simulation, body, rotor_inertia, held=held)
        self.scene.meet(body)
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

    def step(self, torque: Vector) -> None:
        """See `Engine`."""
        self._run(_NO_DRIVES, torque, 1, -1)

    def _run(self, drives: NDArray[Any], torque: Vector, steps: int, change: int) -> None:
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
