"""Values that an engine is given and gives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from bridge.types import SIDES, Array, Quaternion, Side, Vec2, Vec3
from emulator.poses import ORIGIN, Pose, matrix
from emulator.vectors import Rotation

if TYPE_CHECKING:
    from emulator.engine.base import Multibody


@dataclass(frozen=True)
class Surface:
    """Contact properties of the floor and of objects fixed on it.

    Sole and floor together are a bed of independent springs (Winkler's foundation): the pressure at a place is
    the depth there times `stiffness_per_area`. So a sole sinks, tilts under a load off its middle, and resists
    a turn on the spot by the friction of its whole patch: friction x load x mean distance from the middle.
    """

    friction: float
    """Coulomb coefficient against soles."""
    stiffness_per_area: float
    """Pressure per depth, of sole and floor in series, N/m^3."""
    relaxation: float
    """Damping of the bed over its stiffness, s."""


class Surroundings(NamedTuple):
    """Everything of a world that is no body: floor and gravity."""

    gravity: Vec3
    """World frame, m/s^2."""
    surface: Surface | None = None
    """Surface of the floor and everything fixed on it, against soles; None: hard ground with friction 1."""
    floor: Pose = ORIGIN
    """Floor frame in the world."""
    velocity: Vec3 = (0.0, 0.0, 0.0)
    """Velocity of the floor frame's origin, m/s; objects on the floor are carried along."""
    spin: Vec3 = (0.0, 0.0, 0.0)
    """Angular velocity of the floor, world frame, rad/s."""

    @property
    def normal(self) -> Vec3:
        """Normal of the floor, world frame."""
        turn = matrix(self.floor.orientation)
        return turn[2], turn[5], turn[8]


@dataclass(frozen=True)
class Box:
    """A box."""

    size: Vec3
    """Edges along its axes, m."""
    mass: float = 0.0
    """kg; 0: fixed on the floor."""
    friction: float | None = None
    """Its own coefficient; None: the floor's."""


@dataclass(frozen=True)
class Ball:
    """A ball of even density. Rolling on the level floor it loses speed at a constant rate."""

    radius: float
    """Radius of the ball, m."""
    mass: float
    """Mass of the ball, kg."""
    rolling: float
    """Deceleration of the rolling ball, m/s^2."""
    friction: float | None = None
    """As of a `Box`."""

    def rolling_arm(self, gravity: float) -> float:
        """Distance by which the floor's force is ahead of the ball's middle, m: it has this torque.

        The floor's friction m a slows the ball and would spin it up; the torque 7/5 m r a is needed to slow
        its spin by a / r all the same: m r a against the friction, 2/5 m r a against its inertia.

        Args:
            gravity: m/s^2
        """
        return 1.4 * self.radius * self.rolling / gravity


@dataclass(frozen=True)
class Pole:
    """A cylinder along z."""

    radius: float
    """Radius, m."""
    height: float
    """Height, m."""
    mass: float = 0.0
    """As of a `Box`."""
    friction: float | None = None
    """As of a `Box`."""


@dataclass(frozen=True)
class HeightField:
    """A grid of heights, fixed on the floor, linear between its points; placed by its middle at height 0."""

    heights: Array
    """(rows along y, columns along x), m."""
    spacing: float
    """Between two neighbours, m."""


@dataclass(frozen=True)
class Pendulum:
    """A ball on a massless rod without friction, at rest; it falls from the next step on.

    The rod turns about the pivot's y axis, and hangs along -z at angle 0.
    """

    mass: float
    """Mass of the ball, kg."""
    length: float
    """From the pivot to the middle of the ball, m."""
    radius: float
    """Radius of the ball, m."""
    angle: float
    """Angle of the rod, rad; a positive one is on the side of -x."""


Solid = Box | Ball | Pole
"""Objects by their middle."""
ThingShape = Solid | HeightField | Pendulum
"""Objects that an engine takes."""


class BodyState(NamedTuple):
    """A frame that moves, in the world."""

    position: Vec3
    """Position of the frame's origin, m."""
    orientation: Quaternion
    """x, y, z, w."""
    rotation: Rotation
    """Frame to world."""
    velocity: Vec3
    """Velocity of the frame's origin, world frame, m/s."""
    angular_velocity: Vec3
    """World frame, rad/s."""

    @property
    def pose(self) -> Pose:
        """Position and orientation."""
        return Pose(self.position, self.orientation)

    @property
    def heading(self) -> float:
        """Yaw in the world, rad."""
        return math.atan2(self.rotation[3], self.rotation[0])


class FootLoad(NamedTuple):
    """Contact forces on one foot."""

    force: Vec3
    """Sum of the contact forces, world frame, N."""
    normal_force: float
    """Part of it along the sole's normal, N."""
    cop: Vec2 | None
    """Centre of pressure in the sole frame (below the AnkleRoll origin), m; None without load."""
    rim: tuple[Vec3, ...] = ()
    """Points at which something pushes on the rim of the foot and not on its sole, AnkleRoll frame, m."""


class GroundContacts(NamedTuple):
    """All contacts of the robot with the ground, forces as means over a cycle."""

    feet: Mapping[Side, FootLoad]
    zmp: Vec2 | None
    """Centre of pressure of both feet together, world frame x and y, m; None without load. Each foot has the
    weight of its force along the floor's normal, so that this is the zero moment point on a tilted floor
    too."""
    touching: frozenset[str] = frozenset()
    """Links other than the feet that touched the ground: `Torso`, or the joint that moves the link."""


NO_CONTACTS: Final = GroundContacts({side: FootLoad((0.0, 0.0, 0.0), 0.0, None) for side in SIDES}, None)
"""In the air."""


class RayHit(NamedTuple):
    """First surface on the way of a ray."""

    kind: Literal["nothing", "robot", "scene"]
    robot: Multibody | None
    """The one that is hit."""
    fraction: float
    """Fraction of the way from start to end; 1 without a hit."""
    point: Vec3
    """World frame, m."""
    normal: Vec3
    """Normal of the surface, world frame, outward."""


class PinholeCamera(NamedTuple):
    """A pinhole camera with z upward in the picture."""

    eye: Vec3
    """World frame, m."""
    target: Vec3
    """Point in the middle of the picture, world frame, m."""
    width: int
    height: int
    """Pixels."""
    field_of_view: float
    """Vertical angle, rad."""
