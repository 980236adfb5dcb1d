"""Values that an engine is given and gives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.types import Quaternion, Side, Vec2, Vec3

if TYPE_CHECKING:  # `nao-hil up` checks a run without Numba, which takes half a second of its start
    from emulator.vectors import Rotation


@dataclass(frozen=True)
class PhysicsSettings:
    """Settings of every engine."""

    step: float = 0.001
    """Time of one physics and servo step, s (assumed)."""
    gravity: float = 9.81
    """m/s^2"""

    def steps(self, body: Body) -> int:
        """Number of steps in a cycle of a body.

        Raises:
            ConfigurationError: they do not fill the cycle.
        """
        steps = round(body.cycle / self.step)
        if steps < 1 or abs(steps * self.step - body.cycle) > 1e-9:
            raise ConfigurationError(
                f"A physics step of {self.step:g} s does not divide the {body.cycle:g} s cycle of {body.name}."
            )
        return steps


SETTINGS: Final = PhysicsSettings()


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


class TorsoState(NamedTuple):
    """The Torso frame in the world."""

    position: Vec3
    """m"""
    orientation: Quaternion
    """x, y, z, w."""
    rotation: Rotation
    """Torso to world."""
    velocity: Vec3
    """Of the frame's origin, world frame, m/s."""
    angular_velocity: Vec3
    """World frame, rad/s."""

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


class RayHit(NamedTuple):
    """First surface on the way of a ray."""

    kind: Literal["nothing", "robot", "scene"]
    fraction: float
    """Of the way from start to end; 1 without a hit."""
    point: Vec3
    """World frame, m."""
    normal: Vec3
    """Of the surface, world frame, outward."""


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
