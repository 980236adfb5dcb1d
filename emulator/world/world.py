"""Gravity, a floor that can be tilted, and the boxes on it.

The floor is turned, not gravity: the world's z axis stays the vertical, so that accelerometer, fused angle and
ground truth mean the same on every slope. All that is fixed on the floor turns with it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from bridge.messages import Quaternion, Vec2, Vec3
from bridge.world import Terrain
from emulator.engine import bullet
from emulator.world.parameters import WorldParameters

_HERE: Final = (0.0, 0.0, 0.0)
_UPRIGHT: Final = (0.0, 0.0, 0.0, 1.0)
_FIXED: Final = 2
"""PyBullet's collision group of bodies without mass: rays with this mask see the ground and not the robot."""
_HIGH: Final = 5.0
"""Rays start that far above and end that far below the floor's origin, m."""


@dataclass(frozen=True)
class Box:
    """A box in the world."""

    body: int
    """PyBullet's number."""
    size: Vec3
    """m"""
    mass: float
    """kg; 0: fixed on the floor."""
    friction: float | None
    """Against the soles; None: as the floor."""


class BoxState(NamedTuple):
    """A box with where it is and how it moves, world frame."""

    box: Box
    pose: tuple[Vec3, Quaternion]
    velocity: tuple[Vec3, Vec3]


class World:
    """A physics client with a floor and boxes.

    The floor frame begins as the world's and turns with the floor.

    Args:
        client: An empty physics client.
        parameters: Physics settings.
        friction: Of the floor; None: that of the parameters.
        roll: Of the floor, rad: orientation Ry(pitch) Rx(roll), turned about the origin.
        pitch: Of the floor, rad.
    """

    def __init__(
        self,
        client: int,
        parameters: WorldParameters,
        friction: float | None = None,
        roll: float = 0.0,
        pitch: float = 0.0,
    ) -> None:
        self.client, self.parameters = client, parameters
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=parameters.step,
            numSubSteps=0,
            numSolverIterations=parameters.solver_iterations,
            solverResidualThreshold=parameters.solver_residual,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        bullet.setGravity(0.0, 0.0, -parameters.gravity, physicsClientId=client)
        shape = bullet.createCollisionShape(
            bullet.GEOM_PLANE, planeNormal=(0.0, 0.0, 1.0), physicsClientId=client
        )
        self.floor = int(bullet.createMultiBody(0.0, shape, physicsClientId=client))
        """PyBullet's number of the floor."""
        self.bodies = {self.floor}
        """Numbers of the floor and of everything fixed on it."""
        self.boxes: dict[str, Box] = {}
        """By name."""
        self.terrain = Terrain()
        """What of the ground is not flat."""
        self.uneven = False
        """Something is fixed on the floor."""
        self._places: dict[int, tuple[Vec3, Quaternion]] = {self.floor: (_HERE, _UPRIGHT)}
        self.tilt: Vec2 = (0.0, 0.0)
        """Roll and pitch, rad."""
        self.normal: Vec3 = (0.0, 0.0, 1.0)
        """Of the floor, world frame."""
        self.pose: tuple[Vec3, Quaternion] = (_HERE, _UPRIGHT)
        """Floor frame in the world."""
        self.friction = 0.0
        self.set_friction(parameters.friction if friction is None else friction)
        if roll or pitch:
            self.set_tilt(roll, pitch, _HERE)

    def set_friction(self, friction: float) -> None:
        """Change the coefficient of the floor and of the fixed boxes without their own."""
        self.friction = friction
        own = {box.body for box in self.boxes.values() if box.friction is not None}
        for body in self.bodies - own:
            self._surface(body, friction)

    def _surface(self, body: int, friction: float) -> None:
        bullet.changeDynamics(body, -1, lateralFriction=friction, restitution=0.0, physicsClientId=self.client)

    def set_tilt(self, roll: float, pitch: float, pivot: Vec3) -> None:
        """Turn the floor and all that is fixed on it about a point of the world."""
        turn: Quaternion = bullet.getQuaternionFromEuler((roll, pitch, 0.0))
        there = bullet.multiplyTransforms(*bullet.invertTransform(*self.pose), pivot, _UPRIGHT)[0]
        arm = bullet.multiplyTransforms(_HERE, turn, there, _UPRIGHT)[0]
        origin = (pivot[0] - arm[0], pivot[1] - arm[1], pivot[2] - arm[2])
        self.tilt, self.pose = (roll, pitch), (origin, turn)
        matrix = bullet.getMatrixFromQuaternion(turn)
        self.normal = (matrix[2], matrix[5], matrix[8])
        for body, place in self._places.items():
            bullet.resetBasePositionAndOrientation(
                body, *bullet.multiplyTransforms(*self.pose, *place), physicsClientId=self.client
            )

    def to_world(self, position: Vec3, turn: Quaternion = _UPRIGHT) -> tuple[Vec3, Quaternion]:
        """A pose of the floor frame in the world."""
        place: tuple[Vec3, Quaternion] = bullet.multiplyTransforms(*self.pose, position, turn)
        return place

    def to_floor(self, position: Vec3, turn: Quaternion = _UPRIGHT) -> tuple[Vec3, Quaternion]:
        """A pose of the world in the floor frame."""
        inverse = bullet.invertTransform(*self.pose)
        place: tuple[Vec3, Quaternion] = bullet.multiplyTransforms(*inverse, position, turn)
        return place

    def clearance(self, point: Vec3) -> float:
        """Height of a point of the world over the bare floor, along the floor's normal, m."""
        return self.to_floor(point)[0][2]

    def ground(self, points: Sequence[Vec2]) -> list[float]:
        """Height of the ground, fixed things included, over the bare floor at points of the floor frame, m."""
        if not self.uneven:
            return [0.0] * len(points)
        hits = bullet.rayTestBatch(
            [self.to_world((x, y, _HIGH))[0] for x, y in points],
            [self.to_world((x, y, -_HIGH))[0] for x, y in points],
            collisionFilterMask=_FIXED,
            physicsClientId=self.client,
        )
        return [_HIGH - 2.0 * _HIGH * hit[2] for hit in hits]

    def add_box(
        self,
        name: str,
        size: Vec3,
        at: Vec2,
        yaw: float = 0.0,
        *,
        height: float | None = None,
        mass: float = 0.0,
        friction: float | None = None,
    ) -> Box:
        """Put a box, or replace the one of its name.

        Args:
            name: Of the box.
            size: m.
            at: Middle of its bottom, floor frame, m.
            yaw: About the floor's normal, rad.
            height: Of its bottom over the floor, m; None: on the ground under its middle and corners.
            mass: kg; 0: fixed on the floor.
            friction: Against the soles; None: as the floor.
        """
        self.remove_box(name)
        if height is None:
            height = max(self.ground(_footprint(size, at, yaw)))
        client, half = self.client, (size[0] / 2.0, size[1] / 2.0, size[2] / 2.0)
        shape = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
        place = ((at[0], at[1], height + half[2]), bullet.getQuaternionFromEuler((0.0, 0.0, yaw)))
        if mass > 0.0:
            position, turn = self.to_world(*place)
            body = int(
                bullet.createMultiBody(
                    mass, shape, basePosition=position, baseOrientation=turn, physicsClientId=client
                )
            )
            # PyBullet multiplies both partners' coefficients: 1 leaves the floor's for box and floor.
            self._surface(body, 1.0 if friction is None else friction)
            bullet.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0, physicsClientId=client)
        else:
            body = self.add_fixed(shape, *place)
            self._surface(body, self.friction if friction is None else friction)
        self.boxes[name] = Box(body, size, mass, friction)
        return self.boxes[name]

    def add_fixed(self, shape: int, position: Vec3, turn: Quaternion = _UPRIGHT) -> int:
        """Fix a collision shape on the floor, at a pose of the floor frame; returns PyBullet's number."""
        body = int(bullet.createMultiBody(0.0, shape, physicsClientId=self.client))
        self._places[body] = (position, turn)
        self.bodies.add(body)
        self.uneven = True
        there = self.to_world(position, turn)
        bullet.resetBasePositionAndOrientation(body, *there, physicsClientId=self.client)
        self._surface(body, self.friction)
        return body

    def box_as_it_is(self, name: str) -> BoxState | None:
        """What `put_back` takes; None when there is no such box."""
        box = self.boxes.get(name)
        if box is None:
            return None
        pose = bullet.getBasePositionAndOrientation(box.body, physicsClientId=self.client)
        return BoxState(box, pose, bullet.getBaseVelocity(box.body, physicsClientId=self.client))

    def put_back(self, name: str, state: BoxState) -> None:
        """Put a box that was replaced or taken away back as it was."""
        box = state.box
        (x, y, z), turn = self.to_floor(*state.pose)
        yaw = bullet.getEulerFromQuaternion(turn)[2]
        height = z - 0.5 * box.size[2]
        body = self.add_box(
            name, box.size, (x, y), yaw, height=height, mass=box.mass, friction=box.friction
        ).body
        if box.mass > 0.0:
            bullet.resetBasePositionAndOrientation(body, *state.pose, physicsClientId=self.client)
            bullet.resetBaseVelocity(body, *state.velocity, physicsClientId=self.client)

    def remove_box(self, name: str) -> bool:
        """Take a box away; False when there is none."""
        box = self.boxes.pop(name, None)
        if box is None:
            return False
        bullet.removeBody(box.body, physicsClientId=self.client)
        self.bodies.discard(box.body)
        self._places.pop(box.body, None)
        self.uneven = len(self.bodies) > 1
        return True


def _footprint(size: Vec3, at: Vec2, yaw: float) -> list[Vec2]:
    """Middle and corners of a box's bottom; the corners a little inside, so that neighbours do not count."""
    c, s = math.cos(yaw), math.sin(yaw)
    points = [at]
    for sx in (-0.499, 0.499):
        for sy in (-0.499, 0.499):
            x, y = sx * size[0], sy * size[1]
            points.append((at[0] + c * x - s * y, at[1] + s * x + c * y))
    return points
