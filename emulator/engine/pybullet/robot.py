"""The robot's state in PyBullet."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from bridge.body import TORSO
from bridge.types import Array, Vec3
from emulator.engine.base import Multibody
from emulator.engine.pybullet.client import bullet
from emulator.engine.pybullet.model import BASE, BulletModel
from emulator.engine.pybullet.scene import BulletScene
from emulator.engine.values import TorsoState
from emulator.poses import ORIGIN, Pose
from emulator.vectors import Rotation, add, cross, rotate, scaled

_TORQUE = 3
"""Place of the motor's torque in PyBullet's joint states."""


class BulletRobot(Multibody):
    """A robot in a physics client.

    Args:
        model: The robot.
        scene: Its surroundings.
        gravity: m/s^2.
    """

    def __init__(self, model: BulletModel, scene: BulletScene, gravity: float) -> None:
        self.model = model
        """PyBullet's numbers; for tests that ask PyBullet itself."""
        self.joints = model.joints
        self._scene, self._gravity = scene, gravity
        self._numbers = list(model.numbers)
        self._link = {TORSO: BASE} | dict(zip(model.joints, model.numbers, strict=True))
        self._locked: frozenset[str] = frozenset()
        self._pushes: list[tuple[int, Vec3]] = []
        self._hook: int | None = None
        """PyBullet's number of the constraint that holds the torso."""
        _, self._to_torso = bullet.invertTransform(ORIGIN.position, model.torso_principal)
        # PyBullet starts every joint with a motor of its own that brakes
        bullet.setJointMotorControlArray(
            model.robot,
            self._numbers,
            bullet.VELOCITY_CONTROL,
            forces=[0.0] * len(self._numbers),
            physicsClientId=model.client,
        )
        self.read()

    def read(self) -> None:
        """Take over the joints' state from PyBullet."""
        states = bullet.getJointStates(self.model.robot, self._numbers, physicsClientId=self.model.client)
        self.position = np.array([state[0] for state in states])
        self.velocity = np.array([state[1] for state in states])

    def apply(self, torque: Array) -> None:
        """Hand torques (n,), N m, and pushes over to PyBullet, which forgets them after its next step."""
        client, robot = self.model.client, self.model.robot
        bullet.setJointMotorControlArray(
            robot, self._numbers, bullet.TORQUE_CONTROL, forces=torque.tolist(), physicsClientId=client
        )
        for link, force in self._pushes:
            bullet.applyExternalForce(
                robot, link, force, self._com(link), bullet.WORLD_FRAME, physicsClientId=client
            )
        self._pushes.clear()

    def set_joints(self, position: Sequence[float]) -> None:
        """See `Multibody`."""
        for i, angle in zip(self._numbers, position, strict=True):
            bullet.resetJointState(self.model.robot, i, angle, 0.0, physicsClientId=self.model.client)
        self.read()

    def set_torso(self, pose: Pose) -> None:
        """See `Multibody`. PyBullet places the base by its inertial frame."""
        model = self.model
        inertial = bullet.multiplyTransforms(*pose, model.torso_com, model.torso_principal)
        bullet.resetBasePositionAndOrientation(model.robot, *inertial, physicsClientId=model.client)

    def hold_torso(self, held: bool) -> None:
        """See `Multibody`. PyBullet holds the base by its inertial frame."""
        model = self.model
        if self._hook is not None:
            bullet.removeConstraint(self._hook, physicsClientId=model.client)
            self._hook = None
        if held:
            com, turn = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=model.client)
            self._hook = bullet.createConstraint(
                model.robot,
                BASE,
                BASE,
                BASE,
                bullet.JOINT_FIXED,
                (0.0, 0.0, 0.0),
                (0.0, 0.0, 0.0),
                com,
                (0.0, 0.0, 0.0, 1.0),
                turn,
                physicsClientId=model.client,
            )

    def torso(self) -> TorsoState:
        """See `Multibody`."""
        model = self.model
        com, turn = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=model.client)
        velocity, omega = bullet.getBaseVelocity(model.robot, physicsClientId=model.client)
        here = ORIGIN.position
        orientation = bullet.multiplyTransforms(here, turn, here, self._to_torso)[1]
        rotation: Rotation = bullet.getMatrixFromQuaternion(orientation)
        to_origin = scaled(rotate(rotation, model.torso_com), -1.0)
        return TorsoState(
            position=add(com, to_origin),
            orientation=orientation,
            rotation=rotation,
            velocity=add(velocity, cross(omega, to_origin)),
            angular_velocity=omega,
        )

    def link_pose(self, link: str) -> Pose:
        """See `Multibody`."""
        if link == TORSO:
            torso = self.torso()
            return Pose(torso.position, torso.orientation)
        return self.model.link_frame(self._link[link])

    def link_com(self, link: str) -> Vec3:
        """See `Multibody`."""
        return self._com(self._link[link])

    def _com(self, link: int) -> Vec3:
        client, robot = self.model.client, self.model.robot
        com: Vec3 = (
            bullet.getBasePositionAndOrientation(robot, physicsClientId=client)
            if link == BASE
            else bullet.getLinkState(robot, link, computeForwardKinematics=True, physicsClientId=client)
        )[0]
        return com

    def com(self) -> Vec3:
        """See `Multibody`."""
        model = self.model
        torso = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=model.client)[0]
        links = bullet.getLinkStates(
            model.robot, self._numbers, computeForwardKinematics=True, physicsClientId=model.client
        )
        places = np.array([torso, *(link[0] for link in links)])
        x, y, z = (np.array(model.masses) @ places / sum(model.masses)).tolist()
        return x, y, z

    def energy(self) -> float:
        """See `Multibody`."""
        client, robot = self.model.client, self.model.robot
        inertias = np.array(
            [bullet.getDynamicsInfo(robot, i, physicsClientId=client)[2] for i in (BASE, *self._numbers)]
        )
        place, turn = bullet.getBasePositionAndOrientation(robot, physicsClientId=client)
        velocity, spin = bullet.getBaseVelocity(robot, physicsClientId=client)
        links = bullet.getLinkStates(
            robot,
            self._numbers,
            computeLinkVelocity=True,
            computeForwardKinematics=True,
            physicsClientId=client,
        )
        height = np.array([place[2], *(link[0][2] for link in links)])
        velocities = np.array([velocity, *(link[6] for link in links)])
        spins = np.array([spin, *(link[7] for link in links)])
        turns = [turn, *(link[1] for link in links)]
        # kinetic energy of each link about its own principal axes, R^T omega
        axes = np.array([bullet.getMatrixFromQuaternion(q) for q in turns]).reshape(-1, 3, 3)
        local = np.einsum("nij,ni->nj", axes, spins)
        masses = np.array(self.model.masses)
        kinetic = 0.5 * masses @ (velocities**2).sum(axis=1) + 0.5 * (inertias * local**2).sum()
        return float(kinetic + self._gravity * masses @ height)

    def push(self, link: str, force: Vec3) -> None:
        """See `Multibody`."""
        self._pushes.append((self._link[link], force))

    def lock(self, joints: Collection[str], torque: float) -> None:
        """See `Multibody`."""
        locked = frozenset(joints)
        for joint in locked ^ self._locked:
            bullet.setJointMotorControl2(
                self.model.robot,
                self._link[joint],
                bullet.VELOCITY_CONTROL,
                targetVelocity=0.0,
                force=torque if joint in locked else 0.0,
                physicsClientId=self.model.client,
            )
        self._locked = locked

    def lock_torque(self) -> Array:
        """See `Multibody`."""
        states = bullet.getJointStates(self.model.robot, self._numbers, physicsClientId=self.model.client)
        return np.array(
            [s[_TORQUE] if name in self._locked else 0.0 for name, s in zip(self.joints, states, strict=True)]
        )

    def distance(self, name: str) -> float:
        """See `Multibody`."""
        points = bullet.getClosestPoints(
            self.model.robot, self._scene.bodies[name], 0.0, physicsClientId=self.model.client
        )
        return min((point[8] for point in points), default=np.inf)

    def overlap(self) -> float:
        """See `Multibody`."""
        robot, client = self.model.robot, self.model.client
        depths = [
            -point[8]
            for first, second in self.model.pairs
            for point in bullet.getClosestPoints(robot, robot, 0.0, first, second, physicsClientId=client)
        ]
        return max(0.0, *depths) if depths else 0.0
