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
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import Body
from bridge.types import Array, Vec3
from emulator.drives import run_drives, take_over
from emulator.engine.values import GroundContacts, PhysicsSettings, PinholeCamera, RayHit, Surface, TorsoState
from emulator.poses import Pose


class Scene(ABC):
    """Floor and objects of an engine.

    The floor is an infinite plane, z = 0 of the floor frame, which begins as the world's frame. Objects are
    called by names, each used once at a time. Everything fixed on the floor moves with it. Everything here may
    be called between two physics steps of a running robot.

    The coefficient of friction between two things that touch is: sole and floor, box and floor: the floor's;
    sole and box: the box's own if it has one, else the floor's. The rest of the robot has the fraction
    `Body.shapes.shell_friction` of the sole's, and between two limbs the square of it. All contacts are plastic
    (restitution 0).
    Soles touch everything through the surface's bed of springs; other links and boxes are hard.
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
        """Set the surface of the floor, and of everything fixed on it, against soles."""

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
    def add_heightfield(self, name: str, heights: Array, spacing: float, at: Vec3) -> None:
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


class Multibody(ABC):
    """The robot in an engine: a free torso and n hinge joints, all with the data sheet's frames and masses.

    A link is called by the joint that moves it; the free link is `Torso`. Link frames are the data sheet's
    zero-pose aligned joint frames. The engine couples the two HipYawPitch joints, stops every joint at the ends
    of its range, and makes each joint feel its rotor's inertia.
    """

    joints: tuple[str, ...]
    """Names of the n mechanical joints, in the order of every vector here."""
    position: Array
    """Joint angles after the last step, (n,), rad; read only."""
    velocity: Array
    """Joint velocities after the last step, (n,), rad/s; read only."""

    @abstractmethod
    def set_joints(self, position: Sequence[float]) -> None:
        """Put the joints at these angles (n,), rad, at rest."""

    @abstractmethod
    def set_torso(self, pose: Pose) -> None:
        """Put the Torso frame at a pose of the world, at rest; the joints stay as they are."""

    @abstractmethod
    def hold_torso(self, held: bool) -> None:
        """Fix the torso to the world where it is (a robot on a hook), or release it."""

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
        """Block exactly these joints at their present angles, and release all others.

        Args:
            joints: Names.
            torque: Up to which each is held, N m.
        """

    @abstractmethod
    def lock_torque(self) -> Array:
        """Torque that held each blocked joint in the last step, (n,), N m; 0 for the others."""

    @abstractmethod
    def distance(self, name: str) -> float:
        """Distance to an object of the scene, m: negative where they overlap, infinite if they do not touch."""

    @abstractmethod
    def overlap(self) -> float:
        """Depth of the deepest overlap of two limbs that can touch now, m (`shapes.collision_pairs`)."""


class Engine(ABC):
    """A world with a floor and, once it is added, a robot.

    An engine may defer building its model until the first call that needs it: first the scene is set, then the
    robot is added, then both change while the world runs.
    """

    settings: PhysicsSettings
    scene: Scene
    """Floor and objects; a new one after `reset`."""
    robot: Multibody
    """Set by `add_robot`."""

    @abstractmethod
    def add_robot(self, body: Body, rotor_inertia: Array, *, held: bool = False) -> None:
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
    def step(self, torque: Array) -> None:
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
            ground_only: Rays hit the floor and objects fixed on it, and nothing else.
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
