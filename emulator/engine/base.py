"""The interface of a physics engine: all that emulated robots need from physics, and nothing else.

An `Engine` is a world; objects are added to it as a `Thing`, robots as a `Multibody` each. Servos, sensors,
scenarios, faults and the DCM are the same on every engine. Each engine's own means (the place of the rotor's
inertia, the stop of a joint, the softness of a contact, the memory of the drives) stay in its package.

SI units and radians. The world frame has z up; the floor frame turns with the floor. Quaternions: x, y, z, w.
No engine draws random numbers: the same calls give the same bits. Everything may be called between two physics
steps of a running world.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import TORSO, Body
from bridge.types import Array, Closing, Vec3
from emulator.drives import Drives
from emulator.engine.settings import PhysicsSettings
from emulator.engine.values import (
    NO_CONTACTS,
    BodyState,
    GroundContacts,
    PinholeCamera,
    RayHit,
    Surroundings,
    ThingShape,
)
from emulator.poses import Pose, point_of

AT_REST = (0.0, 0.0, 0.0)


class Thing(ABC):
    """A thing in an engine."""

    @abstractmethod
    def state(self) -> BodyState:
        """State of its frame now: of a box's middle, of a pendulum's pivot."""

    @abstractmethod
    def place(self, pose: Pose, velocity: Vec3 = AT_REST, spin: Vec3 = AT_REST) -> None:
        """Put a movable thing.

        Args:
            pose: Of its frame, world frame.
            velocity: Of the frame's origin, world frame, m/s.
            spin: World frame, rad/s.
        """

    @abstractmethod
    def push(self, force: Vec3) -> None:
        """Let a force (world frame, N) act on its centre of mass in the next physics step."""


class Multibody(Thing):
    """A robot in an engine: a free torso and n hinge joints, all with the data sheet's frames and masses.

    A link is called by the joint that moves it; the free link is `Torso`. Link frames are the data sheet's
    zero-pose aligned joint frames. The engine couples the two HipYawPitch joints, stops every joint at the ends
    of its range, and makes each joint feel its rotor's inertia.

    Args:
        body: Data sheet.
        joints: Names of the n mechanical joints, in the order of every vector here.
        drives: That turn the joints.
    """

    def __init__(self, body: Body, joints: tuple[str, ...], drives: Drives) -> None:
        self.body, self.joints, self.drives = body, joints, drives
        self.position: Array = np.zeros(len(joints))
        """Joint angles after the last step, (n,), rad; read only."""
        self.velocity: Array = np.zeros(len(joints))
        """Joint velocities after the last step, (n,), rad/s; read only."""
        self.torque: Array = np.zeros(len(joints))
        """Torque on each joint besides the drives', (n,), N m; its numbers may be set, and last."""
        self.lock_torque: Array = np.zeros(len(joints))
        """Torque that held each blocked joint in the last step, (n,), N m; 0 for the others; read only."""
        self.contacts: GroundContacts = NO_CONTACTS
        """With the ground, as means over the last `Engine.run`."""

    @abstractmethod
    def state(self, link: str = TORSO) -> BodyState:
        """State of a link's frame now. An accelerometer takes the difference of two velocities."""

    @abstractmethod
    def place(
        self,
        pose: Pose,
        velocity: Vec3 = AT_REST,
        spin: Vec3 = AT_REST,
        *,
        joints: Sequence[float] | None = None,
        held: bool = False,
    ) -> None:
        """Put the Torso frame.

        Args:
            pose: World frame.
            velocity: Of the frame's origin, world frame, m/s.
            spin: World frame, rad/s.
            joints: Angles (n,), rad, at rest; None: they stay as they are.
            held: The torso is fixed to the world there (a robot on a hook) until it is placed again.
        """

    @abstractmethod
    def push(self, force: Vec3, link: str = TORSO) -> None:
        """Let a force (world frame, N) act on a link's centre of mass in the next physics step."""

    @abstractmethod
    def com(self) -> Vec3:
        """Centre of mass of the whole robot now, world frame, m."""

    @abstractmethod
    def lock(self, joints: Collection[str], torque: float) -> None:
        """Block exactly these joints at their present angles, and release all others.

        Args:
            joints: Names.
            torque: Up to which each is held, N m.
        """

    def link_com(self, link: str) -> Vec3:
        """Centre of mass of a link now, world frame, m."""
        return point_of(self.state(link).pose, self.body.links[link].com)


class Engine(Closing, ABC):
    """A world with a floor.

    The floor is an infinite plane, z = 0 of the floor frame. Everything fixed on it moves with it.

    The coefficient of friction between two things that touch is: sole and floor, object and floor: the floor's;
    sole and object: the object's own if it has one, else the floor's. The rest of the robot has the fraction
    `Body.shapes.shell_friction` of the sole's, and between two limbs the square of it. All contacts are plastic
    (restitution 0). Soles touch everything through the surface's bed of springs; the rest is hard.

    An engine may defer building its model until the first call that needs it.

    Args:
        settings: Of the physics.
    """

    def __init__(self, settings: PhysicsSettings) -> None:
        self.settings = settings
        self.surroundings = Surroundings(gravity=(0.0, 0.0, -settings.gravity))
        """Floor and gravity as last set; read only."""
        self.robots: list[Multibody] = []
        """In the order in which they were added."""

    @abstractmethod
    def surround(self, surroundings: Surroundings) -> None:
        """Set floor and gravity."""

    @abstractmethod
    def add(self, shape: ThingShape, pose: Pose) -> Thing:
        """Put an object, at rest.

        Args:
            shape: Of the object.
            pose: Of its middle, floor frame; of a pendulum's pivot, world frame.
        """

    @abstractmethod
    def add_robot(self, body: Body, drives: Drives, *, held: bool = False) -> Multibody:
        """Put a robot into the world: zero pose, torso upright at the world's origin.

        Args:
            body: Data sheet.
            drives: Of its joints.
            held: The torso is fixed to the world wherever it is placed (test benches).
        """

    @abstractmethod
    def remove(self, thing: Thing) -> None:
        """Take an object away."""

    @abstractmethod
    def run(self, steps: int, before_step: Callable[[], None] | None = None) -> None:
        """Run physics steps of `settings.step` in which the drives turn the joints.

        Args:
            steps: How many.
            before_step: Called before each, for pushes and changes of the world.
        """

    @abstractmethod
    def rays(self, starts: ArrayLike, ends: ArrayLike, *, ground_only: bool = False) -> list[RayHit]:
        """Cast rays.

        Args:
            starts: World frame, (n, 3), m.
            ends: One for each start, likewise.
            ground_only: Rays hit the floor and objects fixed on it, and nothing else.
        """

    @abstractmethod
    def overlap(self, robot: Multibody, other: Thing) -> float:
        """Depth of the deepest overlap of a robot and another thing now, m; 0 where they do not touch.

        Args:
            robot: Whose links.
            other: An object; the robot itself: its limbs that can touch (`shapes.collision_pairs`).
        """

    @abstractmethod
    def picture(self, camera: PinholeCamera) -> NDArray[np.uint8]:
        """Picture of the world as it is, (height, width, 3), RGB."""
