"""Parameters of a drive that the data sheet does not give; the defaults are an ideal robot's."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import msgspec

from bridge.types import Fraction

NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Positive = Annotated[float, msgspec.Meta(gt=0.0)]


BacklashAngle: TypeAlias = Annotated[float, msgspec.Meta(ge=0.0, le=0.5)]
"""rad; the bound refuses degrees."""


class Backlash(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Backlash between motor and joint, whole width of the dead zone, rad; both sides of the body alike."""

    HeadYaw: BacklashAngle = 0.0
    HeadPitch: BacklashAngle = 0.0
    ShoulderPitch: BacklashAngle = 0.0
    ShoulderRoll: BacklashAngle = 0.0
    ElbowYaw: BacklashAngle = 0.0
    ElbowRoll: BacklashAngle = 0.0
    WristYaw: BacklashAngle = 0.0
    HipYawPitch: BacklashAngle = 0.0
    HipRoll: BacklashAngle = 0.0
    HipPitch: BacklashAngle = 0.0
    KneePitch: BacklashAngle = 0.0
    AnklePitch: BacklashAngle = 0.0
    AnkleRoll: BacklashAngle = 0.0

    def of(self, joint: str) -> float:
        """Backlash of a joint by its full name, rad."""
        width: float = getattr(self, joint if joint.startswith("Head") else joint[1:])
        return width


class Heating(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One heat store per motor, fed by the square of the current, and the protection of the motor."""

    rise: NotNegative = 0.0
    """Final rise of a motor's temperature under its nominal torque, K; 0: heating off."""
    time_constant: Positive = 300.0
    """Time constant of heating and cooling, s."""
    room: float = 25.0
    """Surroundings, and all motors at the start, degrees Celsius."""
    warm: float = 85.0
    """Status 1: the stiffness begins to be lowered, degrees Celsius."""
    hot: float = 90.0
    """Status 2: lowered by 30 %; more beyond."""
    critical: float = 100.0
    """Status 3: no stiffness left."""

    def __post_init__(self) -> None:
        """Raises ValueError for thresholds out of order."""
        if not self.warm < self.hot < self.critical:
            raise ValueError("the temperatures `warm`, `hot` and `critical` must rise in this order")


class ServoParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A drive beyond its data sheet."""

    full_voltage_error: Positive = 0.025
    """Position error at which the loop gives full voltage, rad: with the stall torque it makes the joint's
    compliance, stall torque / full_voltage_error in N m/rad."""
    lead: NotNegative = 0.0025
    """Derivative time of the loop, s."""
    delay: Annotated[float, msgspec.Meta(ge=0.0, le=0.5)] = 0.0
    """From taking over a request to its use in the loop, s, rounded to servo steps."""
    motor_time_constant: Positive = 0.004
    """Mechanical time constant of the motors, rotor inertia x no-load speed / stall torque, s: gives the rotor
    inertia that each joint feels behind its gear."""
    gear_compliance: NotNegative = 0.0
    """Twist of the gear per torque at the joint, rad/(N m)."""
    gear_relaxation: NotNegative = 0.0
    """Damping of the gear's twist over its stiffness, s."""
    backlash: Backlash = Backlash()
    dry_friction: NotNegative = 0.0
    """Dry friction of each joint, N m."""
    load_friction: Fraction = 0.0
    """Dry friction of each gear over the torque that it passes on."""
    brake: Fraction = 0.0
    """Fraction of the stall torque up to which the short-circuited motor brakes at stiffness 0; none below
    0."""
    supply_voltage: Positive = 21.6
    """V; gives the torque constant: volts per no-load speed."""
    heating: Heating = Heating()
