"""What acts on the world for a while, before every physics step: a turning floor, a push, a pendulum."""

from __future__ import annotations

import math
from typing import Final, Protocol

from bridge.messages import Quaternion, Vec3
from emulator.engine import bullet
from emulator.world.world import Box, World

BOB_RADIUS: Final = 0.05
"""Of a pendulum's bob, m."""
_HERE: Final = (0.0, 0.0, 0.0)
_UPRIGHT: Final = (0.0, 0.0, 0.0, 1.0)


class Action(Protocol):
    """Something that goes on for a while."""

    def step(self) -> bool:
        """Act before a physics step; False when this was the last one."""
        ...


class FloorTilt:
    """A turn of the floor, smooth at both ends.

    Args:
        world: Whose floor turns.
        roll: At the end, rad.
        pitch: At the end, rad.
        pivot: Point of the world it turns about, m.
        steps: Physics steps it takes.
    """

    def __init__(self, world: World, roll: float, pitch: float, pivot: Vec3, steps: int) -> None:
        self._world, self._pivot = world, pivot
        self._from, self._to = world.tilt, (roll, pitch)
        self._steps, self._done = max(1, steps), 0

    def step(self) -> bool:
        """Turn on by one step."""
        self._done += 1
        share = 0.5 - 0.5 * math.cos(math.pi * self._done / self._steps)
        roll, pitch = (a + share * (b - a) for a, b in zip(self._from, self._to, strict=True))
        self._world.set_tilt(roll, pitch, self._pivot)
        return self._done < self._steps


class PushForce:
    """A constant force at a link's or box's centre of mass.

    Args:
        world: Where.
        body: PyBullet's number of the robot or box.
        link: Link number; -1: the base.
        force: World frame, N.
        steps: Physics steps it lasts.
        box: The box that is pushed, if it is one: the push ends when it is taken away.
    """

    def __init__(
        self, world: World, body: int, link: int, force: Vec3, steps: int, box: Box | None = None
    ) -> None:
        self._world, self._client, self._box = world, world.client, box
        self._body, self._link, self._force = body, link, force
        self._left = steps

    def step(self) -> bool:
        """Push for one step: PyBullet forgets a force when the step is done."""
        client = self._client
        # by identity: a box that has been replaced may have got the number of the old one
        if self._box is not None and all(box is not self._box for box in self._world.boxes.values()):
            return False
        if self._link < 0:
            point = bullet.getBasePositionAndOrientation(self._body, physicsClientId=client)[0]
        else:
            point = bullet.getLinkState(
                self._body, self._link, computeForwardKinematics=True, physicsClientId=client
            )[0]
        bullet.applyExternalForce(
            self._body, self._link, self._force, point, bullet.WORLD_FRAME, physicsClientId=client
        )
        self._left -= 1
        return self._left > 0


class Pendulum:
    """A bob on a light rod, released at rest: strikes at its lowest point, gone after half a period.

    Args:
        world: Where.
        bob: Middle of the bob when it hangs straight down, world frame, m.
        heading: Horizontal direction in which it moves there, from the world's x axis, rad.
        mass: Of the bob, kg.
        length: From the pivot to the middle of the bob, m.
        angle: At the release, from the vertical, rad.
    """

    def __init__(
        self, world: World, bob: Vec3, heading: float, mass: float, length: float, angle: float
    ) -> None:
        self._client = client = world.client
        below = (0.0, 0.0, -length)
        shape = bullet.createCollisionShape(
            bullet.GEOM_SPHERE, radius=BOB_RADIUS, collisionFramePosition=below, physicsClientId=client
        )
        # The hinge's axis is y of a frame whose x axis is the direction of the strike.
        turn: Quaternion = bullet.getQuaternionFromEuler((0.0, 0.0, heading))
        self.body = int(
            bullet.createMultiBody(
                baseMass=0.0,
                basePosition=(bob[0], bob[1], bob[2] + length),
                baseOrientation=turn,
                linkMasses=[mass],
                linkCollisionShapeIndices=[shape],
                linkVisualShapeIndices=[-1],
                linkPositions=[_HERE],
                linkOrientations=[_UPRIGHT],
                linkInertialFramePositions=[below],
                linkInertialFrameOrientations=[_UPRIGHT],
                linkParentIndices=[0],
                linkJointTypes=[bullet.JOINT_REVOLUTE],
                linkJointAxis=[(0.0, 1.0, 0.0)],
                physicsClientId=client,
            )
        )
        """PyBullet's number."""
        bullet.changeDynamics(
            self.body, 0, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, physicsClientId=client
        )
        bullet.setJointMotorControl2(self.body, 0, bullet.VELOCITY_CONTROL, force=0.0, physicsClientId=client)
        bullet.resetJointState(self.body, 0, angle, 0.0, physicsClientId=client)
        gravity, dt = world.parameters.gravity, world.parameters.step
        # period of a pendulum, to second order in the angle
        half_period = math.pi * math.sqrt(length / gravity) * (1.0 + angle * angle / 16.0)
        self._left = round(half_period / dt)

    def step(self) -> bool:
        """Let it swing; PyBullet does."""
        self._left -= 1
        if self._left > 0:
            return True
        bullet.removeBody(self.body, physicsClientId=self._client)
        return False
