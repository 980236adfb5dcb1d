"""Interface of the world around the robot."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from bridge.types import Vec3
from emulator.engine.values import Surface
from emulator.poses import Pose


class Scene(ABC):
    """Floor and objects of an engine.

    The floor is an infinite plane, z = 0 of the floor frame, which begins as the world's frame. Objects are
    called by names, each used once at a time. Objects fixed on the floor move with it. Everything here may be
    called between two physics steps of a running robot.

    The coefficient of friction between two things that touch is: sole and floor, box and floor: the floor's;
    sole and box: the box's own if it has one, else the floor's. The rest of the robot has the fraction
    `Body.shapes.shell_friction` of the sole's, and between two limbs the square of it. All contacts are plastic
    (restitution 0).
    Soles meet everything through the surface's bed of springs; other links and boxes are hard.
    """

    @abstractmethod
    def place_floor(self, pose: Pose, velocity: Vec3 = (0.0, 0.0, 0.0), spin: Vec3 = (0.0, 0.0, 0.0)) -> None:
        """Put the floor frame, with all that is fixed on the floor, at a pose of the world.

        Args:
            pose: Of the floor frame.
            velocity: Of its origin until the next call, m/s; objects on it are carried along.
            spin: Angular velocity until the next call, world frame, rad/s.
        """

    @abstractmethod
    def set_surface(self, surface: Surface) -> None:
        """Set the contact properties of the floor and of objects fixed on it."""

    @abstractmethod
    def add_box(
        self, name: str, size: Vec3, pose: Pose, *, mass: float = 0.0, friction: float | None = None
    ) -> None:
        """Put a box, at rest.

        Args:
            name: A new one.
            size: Edges along the box's axes, m.
            pose: Of its middle, floor frame.
            mass: kg; 0: fixed on the floor.
            friction: Its own coefficient; None: the floor's.
        """

    @abstractmethod
    def add_heightfield(self, name: str, heights: NDArray[np.float64], spacing: float, at: Vec3) -> None:
        """Fix a grid of heights on the floor, linear between its points.

        Args:
            name: A new one.
            heights: Over `at`, (rows along y, columns along x), m.
            spacing: Between two neighbours, m.
            at: Middle of the grid, floor frame, m.
        """

    @abstractmethod
    def add_pendulum(
        self, name: str, pivot: Pose, mass: float, length: float, radius: float, angle: float
    ) -> None:
        """Hang a ball on a massless rod without friction, at rest; it falls from the next step on.

        Args:
            name: A new one.
            pivot: World frame; the rod turns about the pivot's y axis, and hangs along -z at angle 0.
            mass: Of the ball, kg.
            length: From the pivot to the middle of the ball, m.
            radius: Of the ball, m.
            angle: Of the rod, rad; a positive one is on the side of -x.
        """

    @abstractmethod
    def remove(self, name: str) -> None:
        """Take an object away."""

    @abstractmethod
    def pose(self, name: str) -> Pose:
        """Pose of a box's middle, or a pendulum's pivot, in the world now."""

    @abstractmethod
    def velocity(self, name: str) -> tuple[Vec3, Vec3]:
        """Velocity of a box's middle (m/s) and its angular velocity (rad/s), world frame."""

    @abstractmethod
    def move(self, name: str, pose: Pose, velocity: tuple[Vec3, Vec3]) -> None:
        """Put a movable box at a pose of the world with a velocity as `velocity` gives it."""

    @abstractmethod
    def push(self, name: str, force: Vec3) -> None:
        """Let a force act on a movable box's centre of mass in the next physics step.

        Args:
            name: Of the box.
            force: World frame, N.
        """
