"""Interface of the robot as a multibody system."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.types import Vec3
from emulator.engine.values import TorsoState
from emulator.poses import Pose

Vector = NDArray[np.float64]


class Multibody(ABC):
    """The robot in an engine: a free torso and n hinge joints, all with the data sheet's frames and masses.

    A link is called by the joint that moves it; the free link is `Torso`. Link frames are the data sheet's
    zero-pose aligned joint frames. The engine couples the two HipYawPitch joints, stops every joint at the ends
    of its range, and makes each joint feel its rotor's inertia.
    """

    joints: tuple[str, ...]
    """Names of the n mechanical joints, in the order of every vector here."""
    position: Vector
    """Joint angles after the last step, (n,), rad; read only."""
    velocity: Vector
    """Joint velocities after the last step, (n,), rad/s; read only."""

    @abstractmethod
    def set_joints(self, position: Sequence[float]) -> None:
        """Put the joints at these angles (n,), rad, at rest."""

    @abstractmethod
    def set_torso(self, pose: Pose) -> None:
        """Put the Torso frame at a pose of the world, at rest; the joints stay as they are."""

    @abstractmethod
    def hold_torso(self, held: bool) -> None:
        """Fix the torso to the world where it is (a robot on a hook), or let it go."""

    @abstractmethod
    def torso(self) -> TorsoState:
        """State of the torso now. An accelerometer takes the difference of two velocities."""

    @abstractmethod
    def link_pose(self, link: str) -> Pose:
        """Pose of a link's frame in the world now."""

    @abstractmethod
    def link_com(self, link: str) -> Vec3:
        """Centre of mass of a link now, world frame, m."""

    @abstractmethod
    def com(self) -> Vec3:
        """Centre of mass of the whole robot now, world frame, m."""

    @abstractmethod
    def energy(self) -> float:
        """Kinetic energy, rotors included, and potential energy over the world's origin, J."""

    @abstractmethod
    def push(self, link: str, force: Vec3) -> None:
        """Let a force act on a link's centre of mass in the next physics step.

        Args:
            link: `Torso` or a joint.
            force: World frame, N.
        """

    @abstractmethod
    def lock(self, joints: Collection[str], torque: float) -> None:
        """Block exactly these joints at their present angles, and free all that were blocked before.

        Args:
            joints: Names.
            torque: Up to which each is held, N m.
        """

    @abstractmethod
    def lock_torque(self) -> Vector:
        """Torque with which each blocked joint was held in the last step, (n,), N m; 0 for the others."""

    @abstractmethod
    def distance(self, name: str) -> float:
        """Distance to an object of the scene, m: negative where they overlap, infinite if they do not touch."""

    @abstractmethod
    def overlap(self) -> float:
        """Depth of the deepest overlap of two limbs that can meet now, m (`shapes.collision_pairs`)."""
