"""The events of a scenario, each at a time."""

from __future__ import annotations

import math
from typing import Annotated

import msgspec

from bridge.messages.faults import DcmPause, Fault
from bridge.messages.world import MAX_IMPULSE, Foot, Friction, Impulse
from bridge.types import Vec2, Vec3
from emulator.scenarios.ground import Degrees, NotNegative, Positive, ScenarioTable, Size, Slope


class ScenarioEvent(ScenarioTable, frozen=True, kw_only=True):
    """Base of all events."""

    time: NotNegative
    """Since the world began, s."""
    robot: str = ""
    """Name of the robot that it concerns; empty: the first one."""


class PushEvent(ScenarioEvent, frozen=True, kw_only=True):
    """A push at a centre of mass, in the torso's heading of that moment."""

    target: str = "Torso"
    """`Torso`, the joint that moves the link, or a movable box."""
    impulse: Annotated[float, msgspec.Meta(ge=0.0, le=MAX_IMPULSE)] = 0.0
    """N s"""
    direction: Degrees = 0.0
    """In which it pushes: 0 forward, 90 to the left."""
    vector: tuple[Impulse, Impulse, Impulse] | None = None
    """In place of both: x forward, y left, z up, N s."""
    duration: NotNegative = 0.1

    def __post_init__(self) -> None:
        """Raises ValueError unless it is either a size with a direction or a vector."""
        if (self.impulse > 0.0) == (self.vector is not None):
            raise ValueError("give either `impulse` with `direction`, or `vector`")

    def impulse_vector(self) -> Vec3:
        """Heading frame, N s."""
        if self.vector is not None:
            return self.vector
        angle = math.radians(self.direction)
        return self.impulse * math.cos(angle), self.impulse * math.sin(angle), 0.0


class PlateEvent(ScenarioEvent, frozen=True, kw_only=True):
    """A plate under a foot, from this time on as soon as the foot is high enough."""

    foot: Foot = "swing"
    size: Size = (0.16, 0.08, 0.01)
    shift: Vec2 = (0.0, 0.0)
    """Along the foot's heading and to its left."""
    yaw: Degrees = 0.0
    """Angle of the plate's length against the foot's heading."""
    name: Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9_-]{1,64}$")] = "plate"


class TiltEvent(ScenarioEvent, frozen=True, kw_only=True):
    """The floor turns to this tilt about the point under the torso."""

    roll: Slope = 0.0
    pitch: Slope = 0.0
    duration: NotNegative = 1.0


class FrictionEvent(ScenarioEvent, frozen=True, kw_only=True):
    """The floor's friction changes."""

    friction: Friction


class PendulumEvent(ScenarioEvent, frozen=True, kw_only=True):
    """A pendulum is released and strikes the robot."""

    mass: Positive
    """Mass of the bob."""
    length: Positive = 1.0
    angle: Annotated[float, msgspec.Meta(gt=0.0, le=85.0)]
    """From the vertical at the release, degrees."""
    direction: Degrees = 0.0
    """In which it strikes: 0 from behind, 90 from the right, 180 from the front."""
    height: Positive | None = None
    """Height of the strike over the floor; none: the torso's centre of mass."""


class FaultEvent(ScenarioEvent, frozen=True, kw_only=True):
    """A fault, for a while."""

    duration: NotNegative = 0.0
    """0: to the end."""
    fault: Fault

    def __post_init__(self) -> None:
        """Raises ValueError for a pause of the DCM without an end."""
        if isinstance(self.fault, DcmPause) and self.duration <= 0.0:
            raise ValueError("a pause of the DCM needs a `duration` in s")
