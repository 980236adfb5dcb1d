"""PyBullet behind the engine's interface."""

from __future__ import annotations

import math
import weakref
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import Body
from bridge.types import Vec3
from emulator.engine.base import Engine, Vector
from emulator.engine.pybullet.client import bullet, connect, disconnect
from emulator.engine.pybullet.contacts import BulletContacts
from emulator.engine.pybullet.model import build_model
from emulator.engine.pybullet.robot import BulletRobot
from emulator.engine.pybullet.scene import BulletScene
from emulator.engine.stops import Stops
from emulator.engine.values import GroundContacts, PhysicsSettings, PinholeCamera, RayHit

SOLVER_ITERATIONS: Final = 50
"""Upper bound of the contact solver's sweeps per step; it stops earlier when converged."""
SOLVER_RESIDUAL: Final = 1e-10
"""Converged when the squared change of all impulses is below this. PyBullet's own 1e-7 leaves a standing
robot's contact forces alternating by 0.3 % from step to step; 1e-10 leaves 3e-5 and costs 8 % of a step."""
_WITHOUT_MASS: Final = 2
"""PyBullet's collision group of bodies without mass: rays with this mask meet the ground and not the robot."""
_EVERYTHING: Final = -1
_CLIP: Final = (0.05, 5.0)
"""Minimum and maximum distance that a camera sees, m."""


class BulletEngine(Engine):
    """A physics client with a floor and a robot.

    Args:
        settings: Of the physics.

    Raises:
        LinkError: PyBullet has no client left.
    """

    robot: BulletRobot
    scene: BulletScene

    def __init__(self, settings: PhysicsSettings) -> None:
        self.settings = settings
        self.client = connect()
        """PyBullet's number; for tests that ask PyBullet itself."""
        self._disconnect = weakref.finalize(self, disconnect, self.client)
        self._begin()

    def _begin(self) -> None:
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.settings.step,
            numSubSteps=0,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=SOLVER_RESIDUAL,
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        self.set_gravity((0.0, 0.0, -self.settings.gravity))
        self.scene = BulletScene(self.client)
        self._robot_number: int | None = None

    def add_robot(self, body: Body, rotor_inertia: Vector, *, held: bool = False) -> None:
        """See `Engine`."""
        model = build_model(self.client, body, rotor_inertia=rotor_inertia.tolist(), fixed=held)
        self._robot_number = model.robot
        self.scene.add_soles(model)
        self.robot = BulletRobot(model, self.scene, self.settings.gravity)
        self._stops = Stops(body, model.joints, rotor_inertia, self.settings.step)
        self._contacts = BulletContacts(model)

    def begin_cycle(self) -> None:
        """See `Engine`."""
        self._contacts.begin()

    def step(self, torque: Vector) -> None:
        """See `Engine`."""
        robot = self.robot
        self._stops.brake(robot.position, robot.velocity, torque)
        # torques before pushes: PyBullet clears a body's forces when it is given torques
        robot.apply(torque)
        self.scene.apply()
        self.bare_step()
        self._contacts.take_step()
        robot.read()

    def bare_step(self) -> None:
        """See `Engine`."""
        bullet.stepSimulation(self.client)

    def contacts(self) -> GroundContacts:
        """See `Engine`."""
        return self._contacts.mean(self.scene.ground, self.scene.normal)

    def set_gravity(self, gravity: Vec3) -> None:
        """See `Engine`."""
        bullet.setGravity(*gravity, physicsClientId=self.client)

    def rays(self, starts: ArrayLike, ends: ArrayLike, *, ground_only: bool = False) -> list[RayHit]:
        """See `Engine`."""
        mask = _WITHOUT_MASS if ground_only else _EVERYTHING
        ways = np.asarray(starts).tolist(), np.asarray(ends).tolist()
        hits = bullet.rayTestBatch(*ways, collisionFilterMask=mask, physicsClientId=self.client)
        return [self._hit(*hit) for hit in hits]

    def _hit(self, body: int, _: int, fraction: float, point: Vec3, normal: Vec3) -> RayHit:
        if body < 0:
            return RayHit("nothing", fraction, point, normal)
        return RayHit("robot" if body == self._robot_number else "scene", fraction, point, normal)

    def picture(self, camera: PinholeCamera) -> NDArray[np.uint8]:
        """See `Engine`."""
        width, height = camera.width, camera.height
        view = bullet.computeViewMatrix(camera.eye, camera.target, (0.0, 0.0, 1.0))
        lens = bullet.computeProjectionMatrixFOV(math.degrees(camera.field_of_view), width / height, *_CLIP)
        image: Any = bullet.getCameraImage(
            width, height, view, lens, renderer=bullet.ER_TINY_RENDERER, physicsClientId=self.client
        )[2]
        return np.reshape(np.asarray(image, dtype=np.uint8), (height, width, 4))[:, :, :3]

    def reset(self) -> None:
        """See `Engine`."""
        bullet.resetSimulation(physicsClientId=self.client)
        self._begin()

    def close(self) -> None:
        """See `Engine`."""
        self._disconnect()
        self.client = -1
