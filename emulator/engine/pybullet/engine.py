"""PyBullet behind the engine's interface, with contact forces from its contact points."""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Collection
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import TORSO, Body
from bridge.types import SIDES, Vec3
from emulator.drives import Drives
from emulator.engine.base import Engine, Multibody, Thing
from emulator.engine.contacts import RIM_COSINE, ground_contacts
from emulator.engine.pybullet.client import bullet, connect, disconnect
from emulator.engine.pybullet.model import BASE, BulletModel, build_model
from emulator.engine.pybullet.robot import BulletRobot
from emulator.engine.pybullet.scene import BulletScene, BulletThing
from emulator.engine.settings import PhysicsSettings
from emulator.engine.values import GroundContacts, PinholeCamera, RayHit, Surroundings, ThingShape
from emulator.poses import Pose, matrix


class BulletContacts:
    """Collects the contacts of a robot step by step.

    Args:
        model: The robot.
    """

    def __init__(self, model: BulletModel) -> None:
        self._model = model
        self._reactions = [_FootReaction() for _ in SIDES]
        self._feet = {
            links[side]: foot
            for links in (model.feet, model.pads)
            for side, foot in zip(SIDES, self._reactions, strict=True)
        }
        """By PyBullet's number of the link."""
        self._names = {BASE: TORSO} | dict(zip(model.numbers, model.joints, strict=True))
        self._others: set[tuple[int, int]] = set()
        """PyBullet's numbers of a body and of the robot's link that touched it."""
        self._steps = 0

    def _frames(self) -> list[tuple[float, ...]]:
        """The AnkleRoll frames now: origins and rotation matrices."""
        poses = [self._model.link_frame(self._model.feet[side]) for side in SIDES]
        return [(*pose.position, *matrix(pose.orientation)) for pose in poses]

    def begin(self) -> None:
        """Forget the last cycle; the soles' normals are those of now until `mean`."""
        for foot, frame in zip(self._reactions, self._frames(), strict=True):
            foot.begin((frame[5], frame[8], frame[11]))
        self._others.clear()
        self._steps = 0

    def take_step(self) -> None:
        """Take in the contacts of the physics step just done."""
        feet = self._feet
        for point in bullet.getContactPoints(self._model.robot, physicsClientId=self._model.client):
            foot = feet.get(point[3])
            if foot is not None:
                # force on the robot: along the normal n, and friction along a and b
                n, a, b = point[7], point[11], point[13]
                fn, fa, fb = point[9], point[10], point[12]
                foot.take(
                    n[0] * fn + a[0] * fa + b[0] * fb,
                    n[1] * fn + a[1] * fa + b[1] * fb,
                    n[2] * fn + a[2] * fa + b[2] * fb,
                    point[5],
                    n,
                    fn,
                )
            elif point[8] <= 0.0:
                self._others.add((point[2], point[3]))
        self._steps += 1

    def mean(self, ground: Collection[int], normal: Vec3) -> GroundContacts:
        """Means since `begin`.

        Args:
            ground: PyBullet's numbers of all that counts as ground.
            normal: Of the floor, world frame.
        """
        touching = frozenset(self._names[link] for body, link in self._others if body in ground)
        sums = np.array([foot.sums for foot in self._reactions])
        rim = [(i, place) for i, foot in enumerate(self._reactions) for place in foot.rim]
        return ground_contacts(sums, rim, np.array(self._frames()), max(self._steps, 1), normal, touching)


class _FootReaction:
    """Sums over the contact points and steps of a cycle for one foot."""

    def __init__(self) -> None:
        self.begin((0.0, 0.0, 1.0))

    def begin(self, normal: Vec3) -> None:
        """Forget all contacts; the sole's normal in the world is this from now on."""
        self._sole = normal
        self._fx = self._fy = self._fz = 0.0
        self._normal = self._px = self._py = self._pz = 0.0
        self.rim: list[Vec3] = []
        """Places of the contacts on the rim, world frame, m."""

    @property
    def sums(self) -> tuple[float, ...]:
        """For `ground_contacts`."""
        return self._fx, self._fy, self._fz, self._normal, self._px, self._py, self._pz

    def take(self, x: float, y: float, z: float, place: Vec3, normal: Vec3, normal_force: float) -> None:
        """Add the force of one contact point in one physics step.

        Args:
            x: Of the force on the foot, world frame, N.
            y: Likewise.
            z: Likewise.
            place: Of the contact, world frame, m.
            normal: Of the contact, world frame.
            normal_force: Part of the force along it, N.
        """
        n = self._sole
        # The force along the sole's normal is the weight of the place in the centre of pressure.
        weight = n[0] * x + n[1] * y + n[2] * z
        self._fx += x
        self._fy += y
        self._fz += z
        self._normal += weight
        self._px += weight * place[0]
        self._py += weight * place[1]
        self._pz += weight * place[2]
        if normal_force > 0.0 and abs(n[0] * normal[0] + n[1] * normal[1] + n[2] * normal[2]) < RIM_COSINE:
            self.rim.append(place)


SOLVER_ITERATIONS: Final = 50
"""Upper bound of the contact solver's sweeps per step; it stops earlier when converged."""
SOLVER_RESIDUAL: Final = 1e-10
"""Converged when the squared change of all impulses is below this. PyBullet's own 1e-7 leaves a standing
robot's contact forces alternating by 0.3 % from step to step; 1e-10 leaves 3e-5 and costs 8 % of a step."""
_WITHOUT_MASS: Final = 2
"""PyBullet's collision group of bodies without mass: rays with this mask hit the ground and not the robot."""
_EVERYTHING: Final = -1
_NEAR_FAR: Final = (0.05, 5.0)
"""Minimum and maximum distance that a camera sees, m."""


class BulletEngine(Engine):
    """A physics client with a floor and robots.

    Args:
        settings: Of the physics.

    Raises:
        LinkError: PyBullet has no client left.
    """

    robots: list[BulletRobot]  # type: ignore[assignment]

    def __init__(self, settings: PhysicsSettings) -> None:
        super().__init__(settings)
        self.client = connect()
        """PyBullet's number; for tests that ask PyBullet itself."""
        self._disconnect = weakref.finalize(self, disconnect, self.client)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.settings.step,
            numSubSteps=0,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=SOLVER_RESIDUAL,
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        self._scene = BulletScene(self.client, settings.gravity)
        self._contacts: list[BulletContacts] = []
        self.surround(self.surroundings)

    def surround(self, surroundings: Surroundings) -> None:
        """See `Engine`."""
        self.surroundings = surroundings
        bullet.setGravity(*surroundings.gravity, physicsClientId=self.client)
        self._scene.surround(surroundings)

    def add(self, shape: ThingShape, pose: Pose) -> Thing:
        """See `Engine`."""
        return self._scene.add(shape, pose)

    def add_robot(self, body: Body, drives: Drives, *, held: bool = False) -> Multibody:
        """See `Engine`."""
        model = build_model(self.client, body, rotor_inertia=drives.rotor_inertia.tolist(), fixed=held)
        self._scene.add_soles(model)
        robot = BulletRobot(model, body, drives, self.settings.step)
        self.robots.append(robot)
        self._contacts.append(BulletContacts(model))
        return robot

    def remove(self, thing: Thing) -> None:
        """See `Engine`."""
        assert isinstance(thing, BulletThing)
        self._scene.remove(thing)

    def run(self, steps: int, before_step: Callable[[], None] | None = None) -> None:
        """See `Engine`."""
        robots, collected = self.robots, self._contacts
        for contacts in collected:
            contacts.begin()
        for step in range(steps):
            if before_step is not None:
                before_step()
            # torques before pushes: PyBullet clears a body's forces when it is given torques
            for robot in robots:
                robot.apply(step)
            self._scene.apply()
            bullet.stepSimulation(self.client)
            for robot, contacts in zip(robots, collected, strict=True):
                contacts.take_step()
                robot.read()
        for robot, contacts in zip(robots, collected, strict=True):
            robot.contacts = contacts.mean(self._scene.ground, self._scene.normal)

    def rays(self, starts: ArrayLike, ends: ArrayLike, *, ground_only: bool = False) -> list[RayHit]:
        """See `Engine`."""
        mask = _WITHOUT_MASS if ground_only else _EVERYTHING
        ways = np.asarray(starts).tolist(), np.asarray(ends).tolist()
        hits = bullet.rayTestBatch(*ways, collisionFilterMask=mask, physicsClientId=self.client)
        robots = {robot.model.robot: robot for robot in self.robots}
        return [self._hit(robots, *hit) for hit in hits]

    def _hit(
        self, robots: dict[int, BulletRobot], body: int, _: int, fraction: float, point: Vec3, normal: Vec3
    ) -> RayHit:
        if body < 0:
            return RayHit("nothing", None, fraction, point, normal)
        robot = robots.get(body)
        return RayHit("scene" if robot is None else "robot", robot, fraction, point, normal)

    def overlap(self, robot: Multibody, other: Thing) -> float:
        """See `Engine`."""
        assert isinstance(robot, BulletRobot) and isinstance(other, BulletRobot | BulletThing)
        one = robot.model.robot
        pairs: tuple[tuple[int, ...], ...] = ((),)
        if other is robot:
            two, pairs = one, robot.model.pairs
        else:
            two = other.model.robot if isinstance(other, BulletRobot) else other.number
        depths = [
            -point[8]
            for pair in pairs
            for point in bullet.getClosestPoints(one, two, 0.0, *pair, physicsClientId=self.client)
        ]
        return max(0.0, *depths) if depths else 0.0

    def picture(self, camera: PinholeCamera) -> NDArray[np.uint8]:
        """See `Engine`."""
        width, height = camera.width, camera.height
        view = bullet.computeViewMatrix(camera.eye, camera.target, (0.0, 0.0, 1.0))
        lens = bullet.computeProjectionMatrixFOV(math.degrees(camera.field_of_view), width / height, *_NEAR_FAR)
        image: Any = bullet.getCameraImage(
            width, height, view, lens, renderer=bullet.ER_TINY_RENDERER, physicsClientId=self.client
        )[2]
        return np.reshape(np.asarray(image, dtype=np.uint8), (height, width, 4))[:, :, :3]

    def close(self) -> None:
        """Free the client; harmless when called twice."""
        self._disconnect()
        self.client = -1
