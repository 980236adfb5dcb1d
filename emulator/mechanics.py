"""The robot as a machine: model and servos in the world, run for one cycle at a time, and its true state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bridge.messages import Quaternion, Vec3
from emulator.contacts import GroundContacts, ground_contacts
from emulator.engine import bullet
from emulator.model import RobotModel
from emulator.servo import Servo

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class TorsoState:
    """The Torso frame in the world."""

    position: Vec3
    """m"""
    orientation: Quaternion
    rotation: NDArray[np.float64]
    """3 x 3, torso to world."""
    velocity: Vector
    """Of the frame's origin, world frame, m/s."""
    angular_velocity: Vector
    """World frame, rad/s."""


class Mechanics:
    """Model and servos together.

    Args:
        model: The robot in its physics client.
        servo: Its drives.
        steps: Physics and servo steps per cycle.
        dry_friction: Dry friction of each joint, N m.
    """

    def __init__(self, model: RobotModel, servo: Servo, steps: int, dry_friction: float) -> None:
        self.model, self.servo = model, servo
        self._steps = steps
        self._joints = list(range(len(model.joints)))
        self._read_joints()
        self._from_principal = (
            np.array(bullet.getMatrixFromQuaternion(model.torso_principal)).reshape(3, 3).T.copy()
        )
        self._torso_com = np.array(model.torso_com)
        bullet.setJointMotorControlArray(
            model.robot,
            self._joints,
            bullet.VELOCITY_CONTROL,
            forces=[dry_friction] * len(self._joints),
            physicsClientId=model.client,
        )

    def _read_joints(self) -> None:
        states = bullet.getJointStates(self.model.robot, self._joints, physicsClientId=self.model.client)
        self.position = np.array([state[0] for state in states])
        """Joint angles, rad."""
        self.velocity = np.array([state[1] for state in states])
        """rad/s"""

    def run_cycle(self) -> None:
        """Servo and physics over one cycle."""
        client, robot, joints, servo = self.model.client, self.model.robot, self._joints, self.servo
        apply, step, control = bullet.setJointMotorControlArray, bullet.stepSimulation, bullet.TORQUE_CONTROL
        servo.begin_cycle()
        for _ in range(self._steps):
            torque = servo.torque(self.position, self.velocity)
            apply(robot, joints, control, forces=torque.tolist(), physicsClientId=client)
            step(client)
            self._read_joints()

    def contacts(self) -> GroundContacts:
        """Ground reactions of the last physics step."""
        return ground_contacts(self.model)

    def torso(self) -> TorsoState:
        """The torso now."""
        model = self.model
        com, turn = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=model.client)
        linear, angular = bullet.getBaseVelocity(model.robot, physicsClientId=model.client)
        rotation = np.array(bullet.getMatrixFromQuaternion(turn)).reshape(3, 3) @ self._from_principal
        arm = rotation @ self._torso_com
        omega = np.array(angular)
        x, y, z = (np.array(com) - arm).tolist()
        inverse = bullet.invertTransform((0.0, 0.0, 0.0), model.torso_principal)[1]
        orientation = bullet.multiplyTransforms((0.0, 0.0, 0.0), turn, (0.0, 0.0, 0.0), inverse)[1]
        return TorsoState((x, y, z), orientation, rotation, np.array(linear) - np.cross(omega, arm), omega)

    def com(self) -> Vec3:
        """Centre of mass of the whole robot, world frame, m."""
        model = self.model
        torso = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=model.client)[0]
        links = bullet.getLinkStates(
            model.robot, self._joints, computeForwardKinematics=True, physicsClientId=model.client
        )
        places = np.array([torso, *(link[0] for link in links)])
        x, y, z = (np.array(model.masses) @ places / sum(model.masses)).tolist()
        return x, y, z
