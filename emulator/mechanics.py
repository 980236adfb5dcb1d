"""The robot as a machine: model and servos in the world, run for one cycle at a time, and its true state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from bridge.messages import Quaternion, Vec3
from emulator.contacts import Ground, GroundContacts
from emulator.engine import bullet
from emulator.model import RobotModel
from emulator.reactions import GroundReactions
from emulator.servo import Servo
from emulator.stops import Stops
from emulator.vectors import Rotation, add, cross, rotate, scaled

JAM_TORQUE: Final = 100.0
"""What a jammed gear withstands, N m: far above any motor's stall torque."""
_HERE: Final = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class TorsoState:
    """The Torso frame in the world."""

    position: Vec3
    """m"""
    orientation: Quaternion
    rotation: Rotation
    """Torso to world."""
    velocity: Vec3
    """Of the frame's origin, world frame, m/s."""
    angular_velocity: Vec3
    """World frame, rad/s."""


class Mechanics:
    """Model and servos together.

    Args:
        model: The robot in its physics client.
        servo: Its drives.
        steps: Physics and servo steps per cycle.
        stops: Its joints' mechanical stops.
    """

    def __init__(self, model: RobotModel, servo: Servo, steps: int, stops: Stops) -> None:
        self.model, self.servo = model, servo
        self._steps, self._stops = steps, stops
        self._joints = list(range(len(model.joints)))
        self._read_joints()
        self._reactions = GroundReactions(model)
        self._jammed: frozenset[int] = frozenset()
        _, self._to_torso = bullet.invertTransform(_HERE, model.torso_principal)
        # PyBullet starts every joint with a motor of its own that brakes
        bullet.setJointMotorControlArray(
            model.robot,
            self._joints,
            bullet.VELOCITY_CONTROL,
            forces=[0.0] * len(self._joints),
            physicsClientId=model.client,
        )

    def _read_joints(self) -> None:
        states = bullet.getJointStates(self.model.robot, self._joints, physicsClientId=self.model.client)
        self.position = np.array([state[0] for state in states])
        """Joint angles, rad."""
        self.velocity = np.array([state[1] for state in states])
        """rad/s"""

    def take_pose(self) -> None:
        """Take note that the joints were set from outside; their drives hold them there."""
        self._read_joints()
        self.servo.start(self.position)

    def run_cycle(self, before_step: Callable[[], None] | None = None) -> None:
        """Servo and physics over one cycle; the world may act before every physics step."""
        client, robot, joints, servo = self.model.client, self.model.robot, self._joints, self.servo
        stops = self._stops
        apply, step, control = bullet.setJointMotorControlArray, bullet.stepSimulation, bullet.TORQUE_CONTROL
        self._reactions.begin_cycle()
        for _ in range(self._steps):
            torque = servo.torque(self.position, self.velocity)
            stops.brake(self.position, self.velocity, torque)
            apply(robot, joints, control, forces=torque.tolist(), physicsClientId=client)
            if before_step is not None:
                before_step()
            step(client)
            self._reactions.take_step()
            self._read_joints()
        servo.end_cycle()

    def jam(self, joints: frozenset[int]) -> None:
        """Block these joints where they are, and free all others that were blocked."""
        for joint in joints ^ self._jammed:
            bullet.setJointMotorControl2(
                self.model.robot,
                joint,
                bullet.VELOCITY_CONTROL,
                targetVelocity=0.0,
                force=JAM_TORQUE if joint in joints else 0.0,
                physicsClientId=self.model.client,
            )
        self._jammed = joints

    def contacts(self, ground: Ground) -> GroundContacts:
        """Mean ground reactions of the last cycle; to be called after each."""
        return self._reactions.mean(ground)

    def torso(self) -> TorsoState:
        """The torso now."""
        model = self.model
        com, turn = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=model.client)
        velocity, omega = bullet.getBaseVelocity(model.robot, physicsClientId=model.client)
        orientation = bullet.multiplyTransforms(_HERE, turn, _HERE, self._to_torso)[1]
        rotation: Rotation = bullet.getMatrixFromQuaternion(orientation)
        to_origin = scaled(rotate(rotation, model.torso_com), -1.0)
        return TorsoState(
            position=add(com, to_origin),
            orientation=orientation,
            rotation=rotation,
            velocity=add(velocity, cross(omega, to_origin)),
            angular_velocity=omega,
        )

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
