"""The guard's settings: part of every run's configuration, and of a robot side's.

All defaults are assumed: chosen for a NAO on a flat floor, some by measurements of walks (`docs/guard.md`).
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from bridge.body.postures import POSTURES
from bridge.stance import StanceSettings
from bridge.types import Fraction, NotNegative, Positive
from bridge.validation import unknown_name

Cycles = Annotated[int, msgspec.Meta(ge=1)]
Celsius = Annotated[float, msgspec.Meta(ge=0.0, le=200.0)]


class _Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base: frozen, and a misspelt key is an error."""


class ApproachSettings(_Settings, frozen=True, kw_only=True):
    """The way from the robot's pose to a distant first command."""

    tolerance: Positive = 0.1
    """rad; a first command with every joint this close to the robot's pose is in force at once."""
    speed: Positive = 0.6
    """rad/s of each joint on the way to a more distant one."""


class WatchdogSettings(_Settings, frozen=True, kw_only=True):
    """Reactions to a silent controller; in cycles of the robot."""

    enabled: bool = True
    stride_cycles: Cycles = 7
    """Without a command in a quick step: the guard brings the feet side by side; never with a value from
    `silence_cycles` on."""
    silence_cycles: Cycles = 25
    """Without a command, after which the controller counts as silent."""
    hold_cycles: Cycles = 25
    """Further silence before the crouch, in which the joints hold."""


class CrouchSettings(_Settings, frozen=True, kw_only=True):
    """The descent, and the stiffness at its end."""

    posture: str = "Crouch"
    """One of the published postures."""
    speed: Positive = 0.8
    """rad/s that no joint exceeds on the way."""
    settle_time: NotNegative = 0.3
    """s between the arrival and the ramp of the stiffness."""
    release_time: NotNegative = 0.7
    """s; duration of the ramp of the stiffness to `rest_stiffness`."""
    rest_stiffness: Fraction = 0.1
    """Stiffness of the legs at the end, unless they had less; all other joints get none. Without it the
    emulated robot tips over backwards, because its thighs do not rest on its calves as a real robot's do."""

    def __post_init__(self) -> None:
        """Raises ValueError for a posture that is not published."""
        if self.posture not in POSTURES:
            raise ValueError(unknown_name("posture", self.posture, POSTURES))


class SitSettings(_Settings, frozen=True, kw_only=True):
    """Sitting down after an idle time in the crouch, for bodies with a motion for it."""

    enabled: bool = True
    after: NotNegative = 30.0
    """s of rest in the crouch after silence or with an empty battery."""


class FallSettings(_Settings, frozen=True, kw_only=True):
    """Detection of a fall, and the reaction."""

    enabled: bool = True
    angle: Annotated[float, msgspec.Meta(gt=0.0, le=1.5)] = 0.7
    """rad between the torso and the vertical, by the fused angle."""
    cycles: Cycles = 4
    """Cycles of such a tilt."""
    upright: Annotated[float, msgspec.Meta(gt=0.0, le=1.5)] = 0.35
    """rad; a standing robot with less tilt can fall, or fall again."""
    stood_cycles: Cycles = 50
    """Cycles of such a stand."""
    stiffness: Fraction = 0.1
    """Stiffness of all joints in a fall."""
    rest_time: NotNegative = 1.5
    """s from the beginning of the fall in which no command is taken."""

    def __post_init__(self) -> None:
        """Raises ValueError when a robot could stand and fall at once."""
        if self.upright >= self.angle:
            raise ValueError("fall.upright must be smaller than fall.angle")


class TemperatureSettings(_Settings, frozen=True, kw_only=True):
    """Bounds of the hottest motor, degrees Celsius."""

    warn: Celsius = 85.0
    limit: Celsius = 98.0
    """The robot crouches and releases its joints."""
    resume: Celsius = 80.0
    """Commands are taken again below this."""

    def __post_init__(self) -> None:
        """Raises ValueError when the three do not rise."""
        if not self.resume <= self.warn < self.limit:
            raise ValueError("the temperatures `resume`, `warn` and `limit` must rise in this order")


class SensorSettings(_Settings, frozen=True, kw_only=True):
    """Bounds of the time of sensor values that cannot be read."""

    unreadable_cycles: Cycles = 25
    """For which the last value counts; then the robot crouches and releases its joints. Commands are taken
    again after as many readable ones."""


class BatterySettings(_Settings, frozen=True, kw_only=True):
    """Charge, 0 to 1."""

    warn: Fraction = 0.15
    limit: Fraction = 0.05
    """The robot crouches and releases its joints."""
    resume: Fraction = 0.1
    """Commands are taken again above this."""

    def __post_init__(self) -> None:
        """Raises ValueError when the three do not rise."""
        if not self.limit <= self.resume <= self.warn:
            raise ValueError("the charges `limit`, `resume` and `warn` must rise in this order")


class GuardSettings(_Settings, frozen=True, kw_only=True):
    """All settings of the guard; the table `guard` of a run's configuration."""

    speed_ratio: Annotated[float, msgspec.Meta(gt=0.0, le=10.0)] = 2.0
    """Limit of each joint's speed over its no-load speed (data sheet). Over 1: a command may be ahead of its
    motor for a cycle; the ankles of the dynamic walk need 1.6 when a foot lands."""
    approach: ApproachSettings = ApproachSettings()
    watchdog: WatchdogSettings = WatchdogSettings()
    crouch: CrouchSettings = CrouchSettings()
    sit: SitSettings = SitSettings()
    stance: StanceSettings = StanceSettings()
    fall: FallSettings = FallSettings()
    temperature: TemperatureSettings = TemperatureSettings()
    battery: BatterySettings = BatterySettings()
    sensors: SensorSettings = SensorSettings()
