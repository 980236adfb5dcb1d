"""MuJoCo behind the engine's interface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.types import Vec3
from emulator.engine.base import Engine
from emulator.engine.mujoco.client import mujoco
from emulator.engine.mujoco.contacts import ContactPoints
from emulator.engine.mujoco.model import describe_robot
from emulator.engine.mujoco.picture import Painter
from emulator.engine.mujoco.robot import MujocoRobot
from emulator.engine.mujoco.scene import MujocoScene
from emulator.engine.mujoco.shapes import GROUND_GROUP, OBJECT_GROUP, ROBOT_GROUP
from emulator.engine.mujoco.simulation import Simulation
from emulator.engine.multibody import Vector
from emulator.engine.stops import Stops
from emulator.engine.values import Camera, GroundContacts, PhysicsSettings, RayHit

_LAYERS: Final = 8
"""Surfaces that a ray leaves from inside before it is given up."""
_ON: Final = 1e-6
"""How far behind a surface a ray goes on, as a fraction of its length."""


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
        self.scene.set_shell_friction(body.shapes.shell_friction)
        description = describe_robot(self.simulation, body, rotor_inertia, held=held)
        self.robot = MujocoRobot(description, self.simulation, self.scene)
        self._stops = Stops(body, self.robot.joints, rotor_inertia, self.settings.step)
        self._contacts = ContactPoints(self.simulation, self.robot, self.scene)

    def begin_cycle(self) -> None:
        """See `Engine`."""
        self._contacts.begin()

    def step(self, torque: Vector) -> None:
        """See `Engine`."""
        robot = self.robot
        robot.find()
        self._stops.brake(robot.position, robot.velocity, torque)
        robot.apply(torque)
        self.bare_step()
        self.simulation.data.xfrc_applied[:] = 0.0
        self._contacts.take_step()
        robot.read()

    def bare_step(self) -> None:
        """See `Engine`."""
        self.simulation.step()

    def contacts(self) -> GroundContacts:
        """See `Engine`."""
        return self._contacts.mean()

    def set_gravity(self, gravity: Vec3) -> None:
        """See `Engine`."""
        self.simulation.set_gravity(gravity)

    def rays(self, starts: Sequence[Vec3], ends: Sequence[Vec3], *, ground_only: bool = False) -> list[RayHit]:
        """See `Engine`."""
        groups = np.zeros(6, dtype=np.uint8)
        groups[[GROUND_GROUP] if ground_only else [GROUND_GROUP, ROBOT_GROUP, OBJECT_GROUP]] = 1
        return [self._ray(np.array(a), np.array(b), groups) for a, b in zip(starts, ends, strict=True)]

    def _ray(self, start: Vector, end: Vector, groups: NDArray[np.uint8]) -> RayHit:
        model, data = self.simulation.model, self.simulation.now
        way, geom, normal = end - start, np.zeros(1, dtype=np.int32), np.zeros(3)
        gone = 0.0
        for _ in range(_LAYERS):
            far = mujoco.mj_ray(model, data, start + gone * way, way, groups, True, -1, geom, normal)
            if far < 0.0 or gone + far > 1.0:
                break
            gone += far
            if normal @ way < 0.0:
                x, y, z = (start + gone * way).tolist()
                nx, ny, nz = normal.tolist()
                robot = model.geom_group[geom[0]] == ROBOT_GROUP
                return RayHit("robot" if robot else "scene", gone, (x, y, z), (nx, ny, nz))
            gone += _ON  # it left a shape from inside
        x, y, z = end.tolist()
        return RayHit("nothing", 1.0, (x, y, z), (0.0, 0.0, 0.0))

    def picture(self, camera: Camera) -> NDArray[np.uint8]:
        """See `Engine`."""
        return self._painter.draw(self.simulation.model, self.simulation.now, camera)

    def reset(self) -> None:
        """See `Engine`."""
        self._begin()

    def close(self) -> None:
        """See `Engine`."""
        self._painter.close()
