"""The guard's settings: part of every run's configuration, and of a robot side's.

All defaults are assumed: chosen for a NAO on a flat floor, and measured against the walks where
`docs/guard.md` says so.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from bridge.config import unknown_name
from bridge.datasheet.postures import POSTURES

Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
Positive = Annotated[float, msgspec.Meta(gt=0.0)]
Cycles = Annotated[int, msgspec.Meta(ge=1)]
Celsius = Annotated[float, msgspec.Meta(ge=0.0, le=200.0)]


class _Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base: frozen, and a misspelt key is an error."""


class ApproachSettings(_Table, frozen=True, kw_only=True):
    """From where the robot is to a first command that is not there."""

    tolerance: Positive = 0.1
    """rad; a first command with every joint this close to the robot's pose is taken as it is."""
    speed: Positive = 0.6
    """rad/s of each joint on the way to one that is farther."""


class WatchdogSettings(_Table, frozen=True, kw_only=True):
    """What becomes of a robot whose controller says nothing more; in cycles of the robot."""

    enabled: bool = True
    silence: Cycles = 25
    """Without a command: the controller counts as silent."""
    hold: Cycles = 25
    """Of further silence in which the joints are held, before the crouch begins."""


class CrouchSettings(_Table, frozen=True, kw_only=True):
    """The way down, and how the robot is left there."""

    posture: str = "Crouch"
    """One of the published postures."""
    speed: Positive = 0.8
    """rad/s that no joint exceeds on the way."""
    settle: Annotated[float, msgspec.Meta(ge=0.0)] = 0.3
    """s between the arrival and the beginning of the stiffness' end."""
    fade: Annotated[float, msgspec.Meta(ge=0.0)] = 0.7
    """s in which the stiffness goes down to `rest_stiffness`."""
    rest_stiffness: Share = 0.1
    """0 to 1, of the legs in the end, as far as they had more; all else goes limp. With none the emulated robot
    tips over backwards: what holds a real one in its crouch, thighs on calves and friction, is not emulated."""

    def __post_init__(self) -> None:
        """Raises ValueError for a posture that is not published."""
        if self.posture not in POSTURES:
            raise ValueError(unknown_name("posture", self.posture, POSTURES))


class StanceSettings(_Table, frozen=True, kw_only=True):
    """Which robot stands and is made to crouch; any other goes limp where it is. One foot is enough."""

    sole_tilt: Positive = 0.35
    """rad that its sole is off level at most."""
    reach: Positive = 0.08
    """m that its ankle is ahead of or behind the hip at most; the postures Sit and SitRelax have more."""


class FallSettings(_Table, frozen=True, kw_only=True):
    """When a robot counts as falling, and what it does then."""

    enabled: bool = True
    angle: Annotated[float, msgspec.Meta(gt=0.0, le=1.5)] = 0.7
    """rad between the torso and the vertical, by the fused angle."""
    cycles: Cycles = 4
    """For which it must be leaning that far."""
    upright: Annotated[float, msgspec.Meta(gt=0.0, le=1.5)] = 0.35
    """rad; a robot that leans less stands again, and can fall again."""
    stiffness: Share = 0.1
    """Of all joints in a fall."""
    rest: Annotated[float, msgspec.Meta(ge=0.0)] = 1.5
    """s from the beginning of the fall in which no command is taken."""

    def __post_init__(self) -> None:
        """Raises ValueError when a robot could stand and fall at once."""
        if self.upright >= self.angle:
            raise ValueError("fall.upright must be smaller than fall.angle")


class TemperatureSettings(_Table, frozen=True, kw_only=True):
    """Of the hottest motor, degrees Celsius."""

    warn: Celsius = 85.0
    limit: Celsius = 98.0
    """The robot crouches and lets go."""
    resume: Celsius = 80.0
    """Commands are taken again below this."""

    def __post_init__(self) -> None:
        """Raises ValueError when the three do not rise."""
        if not self.resume <= self.warn < self.limit:
            raise ValueError("the temperatures `resume`, `warn` and `limit` must rise in this order")


class BatterySettings(_Table, frozen=True, kw_only=True):
    """Charge, 0 to 1."""

    warn: Share = 0.15
    limit: Share = 0.05
    """The robot crouches and lets go."""
    resume: Share = 0.1
    """Commands are taken again above this."""

    def __post_init__(self) -> None:
        """Raises ValueError when the three do not rise."""
        if not self.limit <= self.resume <= self.warn:
            raise ValueError("the charges `limit`, `resume` and `warn` must rise in this order")


class GuardSettings(_Table, frozen=True, kw_only=True):
    """All of it; the table `guard` of a run's configuration."""

    speed: Annotated[float, msgspec.Meta(gt=0.0, le=10.0)] = 2.0
    """Times each joint's no-load speed (data sheet) that no command exceeds. Over 1: a request may be ahead of
    its motor for a cycle; the ankles of the dynamic walk ask for 1.6 when a foot touches down."""
    approach: ApproachSettings = ApproachSettings()
    watchdog: WatchdogSettings = WatchdogSettings()
    crouch: CrouchSettings = CrouchSettings()
    stance: StanceSettings = StanceSettings()
    fall: FallSettings = FallSettings()
    temperature: TemperatureSettings = TemperatureSettings()
    battery: BatterySettings = BatterySettings()
