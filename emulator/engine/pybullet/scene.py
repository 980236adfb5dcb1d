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

from typing import Any, Final

from bridge.types import Array, Quaternion, Vec3
from emulator.engine.base import Scene
from emulator.engine.pybullet.client import bullet
from emulator.engine.pybullet.model import BulletModel
from emulator.engine.shapes import OUTER_SHARE, PATCH_RADIUS
from emulator.engine.values import Surface
from emulator.poses import ORIGIN, Pose, compose, matrix
from emulator.vectors import add, cross, scaled

_MAX_CONTACTS = 4
"""Contact points that PyBullet keeps of a hull or a box on a plane."""
_FLOOR: Final = ""
"""Name of the floor among the bodies."""


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


class BulletScene(Scene):
    """Floor and objects of a physics client.

    PyBullet multiplies the friction coefficients of two partners. The robot and movable boxes without a
    coefficient of their own have 1, so that the floor's is that of the pair. Known weakness: a movable box with
    one of its own touches the floor with the product of both.

    Args:
        client: An empty physics client.
    """

    def __init__(self, client: int) -> None:
        self._client = client
        self.bodies: dict[str, int] = {}
        """PyBullet's numbers by name."""
        self._fixed: dict[str, Pose] = {}
        """The floor and everything fixed on it: poses in the floor frame."""
        self._own_friction: set[str] = set()
        self._pushes: list[tuple[int, Vec3]] = []
        self._floor, self._friction = ORIGIN, 1.0
        self._surface: Surface | None = None
        self._soles: BulletModel | None = None
        self.ground: set[int] = set()
        """PyBullet's numbers of the floor and of everything fixed on it."""
        self.normal: Vec3 = (0.0, 0.0, 1.0)
        """Of the floor, world frame."""
        self._fix(_FLOOR, self._shape(bullet.GEOM_PLANE, planeNormal=(0.0, 0.0, 1.0)), ORIGIN)

    def _shape(self, kind: int, **options: Any) -> int:
        return int(bullet.createCollisionShape(kind, physicsClientId=self._client, **options))

    def _set_body_friction(self, body: int, friction: float) -> None:
        bullet.changeDynamics(body, -1, lateralFriction=friction, restitution=0.0, physicsClientId=self._client)

    def _fix(self, name: str, shape: int, pose: Pose) -> None:
        body = int(bullet.createMultiBody(0.0, shape, physicsClientId=self._client))
        self.bodies[name], self._fixed[name] = body, pose
        self.ground.add(body)
        self._put(body, compose(self._floor, pose))
        self._set_body_friction(body, self._friction)

    def _put(self, body: int, pose: Pose) -> None:
        bullet.resetBasePositionAndOrientation(body, *pose, physicsClientId=self._client)

    def place_floor(self, pose: Pose, velocity: Vec3 = (0.0, 0.0, 0.0), spin: Vec3 = (0.0, 0.0, 0.0)) -> None:
        """See `Scene`."""
        self._floor = pose
        turn = matrix(pose.orientation)
        self.normal = (turn[2], turn[5], turn[8])
        for name, place in self._fixed.items():
            here = compose(pose, place)
            self._put(self.bodies[name], here)
            # PyBullet moves a fixed body on by its velocity, and contacts see it
            arm = add(here.position, scaled(pose.position, -1.0))
            bullet.resetBaseVelocity(
                self.bodies[name], add(velocity, cross(spin, arm)), spin, physicsClientId=self._client
            )

    def set_surface(self, surface: Surface) -> None:
        """See `Scene`."""
        self._surface, self._friction = surface, surface.friction
        for name in self._fixed.keys() - self._own_friction:
            self._set_body_friction(self.bodies[name], surface.friction)
        self._soften()

    def add_soles(self, robot: BulletModel) -> None:
        """Enable contact of a robot's soles with the surface."""
        self._soles = robot
        self._soften()

    def _soften(self) -> None:
        """Hand the bed's stiffness and damping over to PyBullet, which keeps them with the soles."""
        if self._soles is not None and self._surface is not None:
            soften_soles(self._soles, self._surface)

    def add_box(
        self, name: str, size: Vec3, pose: Pose, *, mass: float = 0.0, friction: float | None = None
    ) -> None:
        """See `Scene`."""
        shape = self._shape(bullet.GEOM_BOX, halfExtents=(size[0] / 2.0, size[1] / 2.0, size[2] / 2.0))
        if mass > 0.0:
            position, turn = compose(self._floor, pose)
            body = int(
                bullet.createMultiBody(
                    mass, shape, basePosition=position, baseOrientation=turn, physicsClientId=self._client
                )
            )
            self.bodies[name] = body
            self._set_body_friction(body, 1.0 if friction is None else friction)
            bullet.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0, physicsClientId=self._client)
            return
        self._fix(name, shape, pose)
        if friction is not None:
            self._own_friction.add(name)
            self._set_body_friction(self.bodies[name], friction)

    def add_heightfield(self, name: str, heights: Array, spacing: float, at: Vec3) -> None:
        """See `Scene`."""
        rows, columns = heights.shape
        shape = self._shape(
            bullet.GEOM_HEIGHTFIELD,
            meshScale=(spacing, spacing, 1.0),
            heightfieldTextureScaling=1.0,
            heightfieldData=heights.ravel().tolist(),
            # PyBullet's rows are the points along x, whose index runs fastest
            numHeightfieldRows=columns,
            numHeightfieldColumns=rows,
        )
        # PyBullet puts the middle between the lowest and the highest point at the body's origin
        middle = 0.5 * float(heights.min() + heights.max())
        self._fix(name, shape, Pose((at[0], at[1], at[2] + middle)))

    def add_pendulum(
        self, name: str, pivot: Pose, mass: float, length: float, radius: float, angle: float
    ) -> None:
        """See `Scene`."""
        below = (0.0, 0.0, -length)
        body = int(
            bullet.createMultiBody(
                baseMass=0.0,
                basePosition=pivot.position,
                baseOrientation=pivot.orientation,
                linkMasses=[mass],
                linkCollisionShapeIndices=[
                    self._shape(bullet.GEOM_SPHERE, radius=radius, collisionFramePosition=below)
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
        self.bodies[name] = body
        bullet.changeDynamics(
            body, 0, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, physicsClientId=self._client
        )
        bullet.setJointMotorControl2(body, 0, bullet.VELOCITY_CONTROL, force=0.0, physicsClientId=self._client)
        bullet.resetJointState(body, 0, angle, 0.0, physicsClientId=self._client)

    def remove(self, name: str) -> None:
        """See `Scene`."""
        body = self.bodies.pop(name)
        bullet.removeBody(body, physicsClientId=self._client)
        self.ground.discard(body)
        self._fixed.pop(name, None)
        self._own_friction.discard(name)
        self._pushes = [push for push in self._pushes if push[0] != body]

    def pose(self, name: str) -> Pose:
        """See `Scene`."""
        place: tuple[Vec3, Quaternion] = bullet.getBasePositionAndOrientation(
            self.bodies[name], physicsClientId=self._client
        )
        return Pose(*place)

    def velocity(self, name: str) -> tuple[Vec3, Vec3]:
        """See `Scene`."""
        velocity: tuple[Vec3, Vec3] = bullet.getBaseVelocity(self.bodies[name], physicsClientId=self._client)
        return velocity

    def move(self, name: str, pose: Pose, velocity: tuple[Vec3, Vec3]) -> None:
        """See `Scene`."""
        self._put(self.bodies[name], pose)
        bullet.resetBaseVelocity(self.bodies[name], *velocity, physicsClientId=self._client)

    def push(self, name: str, force: Vec3) -> None:
        """See `Scene`."""
        self._pushes.append((self.bodies[name], force))

    def apply(self) -> None:
        """Hand the pushes over to PyBullet, which forgets them after its next step."""
        for body, force in self._pushes:
            point = bullet.getBasePositionAndOrientation(body, physicsClientId=self._client)[0]
            bullet.applyExternalForce(body, -1, force, point, bullet.WORLD_FRAME, physicsClientId=self._client)
        self._pushes.clear()
