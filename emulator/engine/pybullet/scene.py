"""Floor, soles and objects in PyBullet.

Soles in PyBullet: a bed of springs at four points of the outline and four of a pad in the middle.

PyBullet gives a flat hull four contact points on its outline, each a spring with Coulomb friction once it has
a stiffness. Alone they would resist tilting three times, and turning on the spot 1.6 times as much as a patch
with even pressure. So most of the bed is put under a small pad flush with the sole: together they sink and turn
as the patch does. Known weaknesses: which points of the outline carry, PyBullet chooses, with an error of depth
of some 20 um, so that the stiffness against tilting is off by up to 40 %; and a sole on its rim sinks by
springs in a few points, not along a line.
"""

from __future__ import annotations

from typing import Any

from bridge.types import Vec3
from emulator.engine.base import AT_REST, Thing
from emulator.engine.pybullet.client import bullet
from emulator.engine.pybullet.model import BulletModel
from emulator.engine.shapes import OUTER_SHARE, PATCH_RADIUS
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
from emulator.vectors import add, cross, scaled

_MAX_CONTACTS = 4
"""Contact points that PyBullet keeps of a hull or a box on a plane."""


def soften_soles(robot: BulletModel, surface: Surface) -> None:
    """Give both soles the springs of a surface.

    PyBullet multiplies the coefficient against turning by the floor's friction: it is a length here.

    Args:
        robot: With soles and pads.
        surface: Under it.
    """
    stiffness = surface.stiffness_per_area * robot.sole_area / _MAX_CONTACTS
    shares = ((robot.feet, OUTER_SHARE), (robot.pads, 1.0 - OUTER_SHARE))
    for links, share in shares:
        for link in links.values():
            bullet.changeDynamics(
                robot.robot,
                link,
                contactStiffness=share * stiffness,
                contactDamping=share * stiffness * surface.relaxation,
                spinningFriction=PATCH_RADIUS,
                physicsClientId=robot.client,
            )


class BulletThing(Thing):
    """An object of a physics client.

    Args:
        client: Its number.
        number: PyBullet's of the body.
        fixed: Pose in the floor frame; None: it is not fixed on the floor.
    """

    def __init__(self, client: int, number: int, fixed: Pose | None = None) -> None:
        self._client, self.number, self.fixed = client, number, fixed
        self.own_friction = False
        self.rolling_arm = 0.0
        """Lever of a ball's rolling friction, m."""
        self.pushes: list[Vec3] = []
        """Forces of the next step, world frame, N."""

    def set_friction(self, friction: float) -> None:
        """Set the coefficient, which PyBullet multiplies with the partner's."""
        bullet.changeDynamics(
            self.number, -1, lateralFriction=friction, restitution=0.0, physicsClientId=self._client
        )

    def state(self) -> BodyState:
        """See `Thing`."""
        position, turn = bullet.getBasePositionAndOrientation(self.number, physicsClientId=self._client)
        velocity, spin = bullet.getBaseVelocity(self.number, physicsClientId=self._client)
        return BodyState(position, turn, matrix(turn), velocity, spin)

    def place(self, pose: Pose, velocity: Vec3 = AT_REST, spin: Vec3 = AT_REST) -> None:
        """See `Thing`."""
        bullet.resetBasePositionAndOrientation(self.number, *pose, physicsClientId=self._client)
        bullet.resetBaseVelocity(self.number, velocity, spin, physicsClientId=self._client)

    def push(self, force: Vec3) -> None:
        """See `Thing`."""
        self.pushes.append(force)

    def apply(self) -> None:
        """Hand the pushes over to PyBullet, which forgets them after its next step."""
        for force in self.pushes:
            point = bullet.getBasePositionAndOrientation(self.number, physicsClientId=self._client)[0]
            bullet.applyExternalForce(
                self.number, -1, force, point, bullet.WORLD_FRAME, physicsClientId=self._client
            )
        self.pushes.clear()


class BulletScene:
    """Floor and objects of a physics client.

    PyBullet multiplies the friction coefficients of two partners. The robot and movable boxes without a
    coefficient of their own have 1, so that the floor's is that of the pair. Known weakness: a movable box with
    one of its own touches the floor with the product of both.

    Args:
        client: An empty physics client.
        gravity: m/s^2
    """

    def __init__(self, client: int, gravity: float) -> None:
        self._client, self._gravity = client, gravity
        self._things: list[BulletThing] = []
        """The floor first."""
        self._floor, self._moving, self._friction = ORIGIN, False, 1.0
        self._surface: Surface | None = None
        self._soles: list[BulletModel] = []
        self.ground: set[int] = set()
        """PyBullet's numbers of the floor and of everything fixed on it."""
        self.normal: Vec3 = (0.0, 0.0, 1.0)
        """Normal of the floor, world frame."""
        self._fix(self._shape(bullet.GEOM_PLANE, planeNormal=(0.0, 0.0, 1.0)), ORIGIN)

    def _shape(self, kind: int, **options: Any) -> int:
        return int(bullet.createCollisionShape(kind, physicsClientId=self._client, **options))

    def _fix(self, shape: int, pose: Pose) -> BulletThing:
        body = int(bullet.createMultiBody(0.0, shape, physicsClientId=self._client))
        thing = BulletThing(self._client, body, pose)
        self._things.append(thing)
        self.ground.add(body)
        bullet.resetBasePositionAndOrientation(body, *compose(self._floor, pose), physicsClientId=self._client)
        thing.set_friction(self._friction)
        return thing

    def surround(self, new: Surroundings) -> None:
        """Place the floor with all that is fixed on it, and set its surface, where they change."""
        moves = (self._floor, AT_REST, AT_REST) != (new.floor, new.velocity, new.spin)
        if moves or self._moving:
            self._place_floor(new)
        if new.surface is not None and new.surface is not self._surface:
            self._surface, self._friction = new.surface, new.surface.friction
            for thing in self._things:
                if thing.fixed is not None and not thing.own_friction:
                    thing.set_friction(self._friction)
                if thing.rolling_arm > 0.0:
                    self._set_rolling(thing)
            self._soften()

    def _place_floor(self, new: Surroundings) -> None:
        self._floor, self.normal = new.floor, new.normal
        self._moving = (new.velocity, new.spin) != (AT_REST, AT_REST)
        for thing in self._things:
            if thing.fixed is not None:
                here = compose(new.floor, thing.fixed)
                # PyBullet moves a fixed body on by its velocity, and contacts see it
                arm = add(here.position, scaled(new.floor.position, -1.0))
                thing.place(here, add(new.velocity, cross(new.spin, arm)), new.spin)

    def add_soles(self, robot: BulletModel) -> None:
        """Enable contact of a robot's soles with the surface."""
        self._soles.append(robot)
        self._soften()

    def _soften(self) -> None:
        """Hand the bed's stiffness and damping over to PyBullet, which keeps them with the soles."""
        if self._surface is not None:
            for robot in self._soles:
                soften_soles(robot, self._surface)

    def add(self, shape: ThingShape, pose: Pose) -> BulletThing:
        """See `Engine.add`."""
        if isinstance(shape, Box | Pole):
            return self._add_solid(shape, pose)
        if isinstance(shape, Ball):
            return self._add_ball(shape, pose)
        if isinstance(shape, HeightField):
            return self._add_heightfield(shape, pose)
        return self._add_pendulum(shape, pose)

    def _add_ball(self, ball: Ball, pose: Pose) -> BulletThing:
        shape = self._shape(bullet.GEOM_SPHERE, radius=ball.radius)
        friction = 1.0 if ball.friction is None else ball.friction
        thing = self._add_movable(shape, ball.mass, pose, friction)
        thing.rolling_arm = ball.rolling_arm(self._gravity)
        self._set_rolling(thing)
        return thing

    def _set_rolling(self, thing: BulletThing) -> None:
        """Set the rolling friction, which PyBullet multiplies with the floor's coefficient of friction."""
        bullet.changeDynamics(
            thing.number,
            -1,
            rollingFriction=thing.rolling_arm / max(self._friction, 1e-6),
            physicsClientId=self._client,
        )

    def _add_solid(self, box: Box | Pole, pose: Pose) -> BulletThing:
        if isinstance(box, Pole):
            shape = self._shape(bullet.GEOM_CYLINDER, radius=box.radius, height=box.height)
        else:
            x, y, z = box.size
            shape = self._shape(bullet.GEOM_BOX, halfExtents=(x / 2.0, y / 2.0, z / 2.0))
        if box.mass > 0.0:
            return self._add_movable(shape, box.mass, pose, 1.0 if box.friction is None else box.friction)
        thing = self._fix(shape, pose)
        if box.friction is not None:
            thing.own_friction = True
            thing.set_friction(box.friction)
        return thing

    def _add_movable(self, shape: int, mass: float, pose: Pose, friction: float) -> BulletThing:
        position, turn = compose(self._floor, pose)
        body = int(
            bullet.createMultiBody(
                mass, shape, basePosition=position, baseOrientation=turn, physicsClientId=self._client
            )
        )
        thing = BulletThing(self._client, body)
        self._things.append(thing)
        thing.set_friction(friction)
        bullet.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0, physicsClientId=self._client)
        return thing

    def _add_heightfield(self, field: HeightField, pose: Pose) -> BulletThing:
        rows, columns = field.heights.shape
        shape = self._shape(
            bullet.GEOM_HEIGHTFIELD,
            meshScale=(field.spacing, field.spacing, 1.0),
            heightfieldTextureScaling=1.0,
            heightfieldData=field.heights.ravel().tolist(),
            # PyBullet's rows are the points along x, whose index runs fastest
            numHeightfieldRows=columns,
            numHeightfieldColumns=rows,
        )
        # PyBullet puts the middle between the lowest and the highest point at the body's origin
        x, y, z = pose.position
        middle = 0.5 * float(field.heights.min() + field.heights.max())
        return self._fix(shape, Pose((x, y, z + middle), pose.orientation))

    def _add_pendulum(self, pendulum: Pendulum, pivot: Pose) -> BulletThing:
        below = (0.0, 0.0, -pendulum.length)
        body = int(
            bullet.createMultiBody(
                baseMass=0.0,
                basePosition=pivot.position,
                baseOrientation=pivot.orientation,
                linkMasses=[pendulum.mass],
                linkCollisionShapeIndices=[
                    self._shape(bullet.GEOM_SPHERE, radius=pendulum.radius, collisionFramePosition=below)
                ],
                linkVisualShapeIndices=[-1],
                linkPositions=[ORIGIN.position],
                linkOrientations=[ORIGIN.orientation],
                linkInertialFramePositions=[below],
                linkInertialFrameOrientations=[ORIGIN.orientation],
                linkParentIndices=[0],
                linkJointTypes=[bullet.JOINT_REVOLUTE],
                linkJointAxis=[(0.0, 1.0, 0.0)],
                physicsClientId=self._client,
            )
        )
        bullet.changeDynamics(
            body, 0, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, physicsClientId=self._client
        )
        bullet.setJointMotorControl2(body, 0, bullet.VELOCITY_CONTROL, force=0.0, physicsClientId=self._client)
        bullet.resetJointState(body, 0, pendulum.angle, 0.0, physicsClientId=self._client)
        thing = BulletThing(self._client, body)
        self._things.append(thing)
        return thing

    def remove(self, thing: BulletThing) -> None:
        """See `Engine.remove`."""
        self._things.remove(thing)
        bullet.removeBody(thing.number, physicsClientId=self._client)
        self.ground.discard(thing.number)

    def apply(self) -> None:
        """Hand all pushes over to PyBullet."""
        for thing in self._things:
            if thing.pushes:
                thing.apply()
