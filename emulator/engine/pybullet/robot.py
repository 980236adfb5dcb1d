"""The robot's state in PyBullet."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from bridge.body import TORSO, Body
from bridge.types import Vec3
from emulator.drives import Drives, run_drives, take_over
from emulator.engine.base import AT_REST, Multibody
from emulator.engine.contacts import Stops
from emulator.engine.pybullet.client import bullet
from emulator.engine.pybullet.model import BASE, BulletModel
from emulator.engine.values import BodyState
from emulator.poses import ORIGIN, Pose
from emulator.vectors import Rotation, add, cross, rotate, scaled

_TORQUE = 3
"""Place of the motor's torque in PyBullet's joint states."""


class BulletRobot(Multibody):
    """A robot in a physics client.

    Args:
        model: The robot.
        body: Data sheet.
        drives: Of its joints.
        step: Physics step, s.
    """

    def __init__(self, model: BulletModel, body: Body, drives: Drives, step: float) -> None:
        super().__init__(body, model.joints, drives)
        self.model = model
        """PyBullet's numbers; for tests that ask PyBullet itself."""
        self._stops = Stops(body, model.joints, drives.rotor_inertia, step)
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
        if self._locked:
            torques = [
                s[_TORQUE] if name in self._locked else 0.0 for name, s in zip(self.joints, states, strict=True)
            ]
            self.lock_torque = np.array(torques)

    def apply(self, step: int) -> None:
        """Hand the torques of a step of a run over to PyBullet, and pushes, which it forgets after the step."""
        drives, torque = self.drives.records, np.zeros(len(self.joints))
        if step == self.drives.change:
            take_over(drives)
        run_drives(drives, self.position, self.velocity, torque)
        torque += self.torque
        self._stops.brake(self.position, self.velocity, torque)
        client, robot = self.model.client, self.model.robot
        bullet.setJointMotorControlArray(
            robot, self._numbers, bullet.TORQUE_CONTROL, forces=torque.tolist(), physicsClientId=client
        )
        for link, force in self._pushes:
            bullet.applyExternalForce(
                robot, link, force, self._com(link), bullet.WORLD_FRAME, physicsClientId=client
            )
        self._pushes.clear()

    def place(
        self,
        pose: Pose,
        velocity: Vec3 = AT_REST,
        spin: Vec3 = AT_REST,
        *,
        joints: Sequence[float] | None = None,
        held: bool = False,
    ) -> None:
        """See `Multibody`. PyBullet places and holds the base by its inertial frame."""
        model = self.model
        if self._hook is not None:
            bullet.removeConstraint(self._hook, physicsClientId=model.client)
            self._hook = None
        if joints is not None:
            for i, angle in zip(self._numbers, joints, strict=True):
                bullet.resetJointState(model.robot, i, angle, 0.0, physicsClientId=model.client)
            self.read()
        inertial = bullet.multiplyTransforms(*pose, model.torso_com, model.torso_principal)
        bullet.resetBasePositionAndOrientation(model.robot, *inertial, physicsClientId=model.client)
        if velocity != AT_REST or spin != AT_REST:
            arm = add(inertial[0], scaled(pose.position, -1.0))
            of_com = add(velocity, cross(spin, arm))
            bullet.resetBaseVelocity(model.robot, of_com, spin, physicsClientId=model.client)
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

    def state(self, link: str = TORSO) -> BodyState:
        """See `Multibody`."""
        return self._torso() if link == TORSO else self._state(self._link[link])

    def _torso(self) -> BodyState:
        model = self.model
        com, turn = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=model.client)
        velocity, omega = bullet.getBaseVelocity(model.robot, physicsClientId=model.client)
        here = ORIGIN.position
        orientation = bullet.multiplyTransforms(here, turn, here, self._to_torso)[1]
        rotation: Rotation = bullet.getMatrixFromQuaternion(orientation)
        to_origin = scaled(rotate(rotation, model.torso_com), -1.0)
        return BodyState(
            position=add(com, to_origin),
            orientation=orientation,
            rotation=rotation,
            velocity=add(velocity, cross(omega, to_origin)),
            angular_velocity=omega,
        )

    def _state(self, link: int) -> BodyState:
        """State of a link but the torso, by PyBullet's number."""
        com, _, _, _, position, orientation, velocity, spin = bullet.getLinkState(
            self.model.robot,
            link,
            computeLinkVelocity=True,
            computeForwardKinematics=True,
            physicsClientId=self.model.client,
        )
        from_com = add(position, scaled(com, -1.0))
        rotation: Rotation = bullet.getMatrixFromQuaternion(orientation)
        return BodyState(position, orientation, rotation, add(velocity, cross(spin, from_com)), spin)

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

    def push(self, force: Vec3, link: str = TORSO) -> None:
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
        self._locked, self.lock_torque = locked, np.zeros(len(self.joints))
