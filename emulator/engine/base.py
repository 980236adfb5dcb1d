"""The interface of a physics engine: everything that the emulated robot needs from physics, and nothing else.

Servos, sensors, scenarios, faults and the DCM are the same on every engine. Each engine's own means (the
place of the rotor's inertia, the stop of a joint, the softness of a contact) stay in its package.

SI units and radians. The world frame has z up; a scene's floor frame turns with the floor. Quaternions are x,
y, z, w. No engine draws random numbers: the same calls after `reset` give the same bits.

One engine holds one robot. The methods of every physics step or cycle (`run`, `contacts`, the robot's
`position`, `velocity` and `torso`) take and give arrays and plain values and call nothing back, so that an
engine of N robots can do the same with a leading axis of N.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import Body
from bridge.types import Vec3
from emulator.drives import run_drives, take_over
from emulator.engine.multibody import Multibody, Vector
from emulator.engine.scene import Scene
from emulator.engine.values import GroundContacts, PhysicsSettings, PinholeCamera, RayHit


class Engine(ABC):
    """A world with a floor and, once it is added, a robot.

    An engine may put off building its model until the first call that needs it: the scene is laid, then the
    robot is added, then both change while the world runs.
    """

    settings: PhysicsSettings
    scene: Scene
    """Floor and objects; a new one after `reset`."""
    robot: Multibody
    """Set by `add_robot`."""

    @abstractmethod
    def add_robot(self, body: Body, rotor_inertia: Vector, *, held: bool = False) -> None:
        """Put the robot into the world: zero pose, torso upright at the world's origin, no torque on any joint.

        Args:
            body: Data sheet.
            rotor_inertia: Of each motor, reflected to its joint, (n,) in the order of `bridge.body.joint_tree`,
                kg m^2.
            held: The torso is fixed to the world wherever it is put (test benches).
        """

    @abstractmethod
    def begin_cycle(self) -> None:
        """Forget the contacts so far: a new mean begins."""

    def run(self, drives: NDArray[Any], steps: int, change: int) -> None:
        """Run physics steps in which drives turn the joints, with the pushes given since the last step.

        Args:
            drives: Of `emulator.drives.DRIVE`, (n,); their state changes.
            steps: How many.
            change: Step, from 0, before which the drives take over their next request; -1: none.
        """
        torque = np.zeros(len(drives))
        for step in range(steps):
            if step == change:
                take_over(drives)
            run_drives(drives, self.robot.position, self.robot.velocity, torque)
            self.step(torque)

    @abstractmethod
    def step(self, torque: Vector) -> None:
        """Run one physics step of `settings.step` with the pushes given since the last one.

        Args:
            torque: Of the drives, (n,), N m; the engine may change the array.
        """

    @abstractmethod
    def bare_step(self) -> None:
        """The engine's own time step alone, nothing applied and nothing read: the floor of a benchmark."""

    @abstractmethod
    def contacts(self) -> GroundContacts:
        """Contacts of the robot with the ground, as means over the steps since `begin_cycle`."""

    @abstractmethod
    def set_gravity(self, gravity: Vec3) -> None:
        """Set the acceleration of gravity, world frame, m/s^2; (0, 0, -`settings.gravity`) at first."""

    @abstractmethod
    def rays(self, starts: ArrayLike, ends: ArrayLike, *, ground_only: bool = False) -> list[RayHit]:
        """Cast rays.

        Args:
            starts: World frame, (n, 3), m.
            ends: One for each start, likewise.
            ground_only: Rays meet the floor and objects fixed on it, and nothing else.
        """

    @abstractmethod
    def picture(self, camera: PinholeCamera) -> NDArray[np.uint8]:
        """Picture of the world as it is, (height, width, 3), RGB."""

    @abstractmethod
    def reset(self) -> None:
        """Empty the world: a level floor at the origin, no objects, no robot."""

    @abstractmethod
    def close(self) -> None:
        """Free the engine's resources; harmless when called twice."""
