"""Types of the controller's parameters."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

from walker.admittance import AnkleParameters, LegParameters
from walker.estimation.ground import GroundParameters
from walker.sag import SagParameters
from walker.torso.damping import DampingParameters
from walker.torso.filter import TorsoLimits

TorsoMethod = Literal["none", "thesis", "robust"]
"""How the torso controller is designed: not at all, as in thesis 4.2.2, or for bounds at a spread of plants."""

_Positive = Annotated[float, msgspec.Meta(gt=0.0)]
_NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
_Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]


class ContactParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a foot counts as touching the ground, by the sum of its four force sensors."""

    on: _Positive = 3.0
    """Sum above which a foot that was in the air touches, N: 6 % of the weight, over the sensors' noise and
    below the 5 N that the leg admittance lets come up."""
    off: _Positive = 1.5
    """Sum below which a foot that touched is in the air, N."""

    def __post_init__(self) -> None:
        if self.off >= self.on:
            raise ValueError(f"off = {self.off} N must be less than on = {self.on} N")


class LevellingParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Levelling of the swing foot."""

    share: _Share = 1.0
    """Of the measured angle that is made up for."""
    largest: _Positive = math.radians(12.0)
    """Largest turn about an axis, rad: 12 degrees of roll lift the foot by 20 mm."""
    rate: _Positive = 1.5
    """Fastest change in the air, rad/s."""
    fade: _Positive = 0.2
    """Speed at which the turn goes once the foot stands, rad/s: 7 degrees in 0.6 s."""


class TouchDownParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What happens when the plan puts a foot down and there is no ground; part of the admittance."""

    hold: _NotNegative = 0.0
    """Longest time for which the plan waits for the ground, s."""
    reach: _NotNegative = 0.010
    """How far the foot is lowered beyond `leg.reach_below` in search of the ground, m."""
    rate: _Positive = 0.04
    """Speed of that, m/s."""


class AttitudeParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How fast the fused torso angle follows the mean of the accelerometer; both 0: not at all."""

    proportional: _NotNegative = 0.3
    """1/s: the mean is over 3 s, three strides of the dynamic gait."""
    integral: _NotNegative = 0.02
    """1/s^2: finds a constant drift within half a minute."""
    largest: _Positive = 0.5
    """Largest error that counts in one cycle, share of gravity."""


class FallParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the robot counts as falling, and what then."""

    angle: Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)] = math.radians(30.0)
    """Fused torso roll or pitch, rad. With the mass 0.23 m above a sole that ends 0.10 m ahead and 0.05 m
    behind, no ankle brings a NAO back from 24 degrees; the rest is for the error of the fused angle."""
    no_support: _Positive = 0.5
    """Time in the walk for which no foot touches, s: lifted, or lying on its back with the legs in the air."""
    stiffness: _Share = 0.1
    """Stiffness while falling and lying: the gears give way, the limbs do not flap."""


class TorsoDesignParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Plant and specification of the torso controller (thesis 4.2)."""

    rise_time: _Positive
    """t_r, s; not used by the robust design, whose bounds decide."""
    overshoot: _NotNegative
    """Share of the final value; not used by the robust design."""
    notch_factor: _Positive = 6.0
    """a_Notch (4.16); not used by the robust design."""
    plant_numerator: tuple[float, ...] = (-0.125, 1.0)
    """G_s(s), highest power first (4.12), in the thesis' sign (`walker.torso.sign`)."""
    plant_denominator: tuple[float, ...] = (0.02041, 0.02857, 1.0)


class ControllerParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything of the controller that may be switched or tuned, SI units and rad."""

    admittance: bool
    """Leg and ankle admittance, levelling, and the search for ground that comes late (thesis 4.1)."""
    torso: TorsoMethod
    """Torso control (thesis 4.2); with `robust` the gyroscope damps as well, see `damping`."""
    ankle_admittance: bool = True
    """False: of the admittances that of the legs alone."""
    torso_design: TorsoDesignParameters
    torso_limits: TorsoLimits = TorsoLimits()
    damping: DampingParameters = DampingParameters()
    sag: SagParameters = SagParameters()
    leg: LegParameters = LegParameters()
    ankle: AnkleParameters = AnkleParameters()
    levelling: LevellingParameters = LevellingParameters()
    ground: GroundParameters = GroundParameters()
    touch_down: TouchDownParameters = TouchDownParameters()
    level_rate: _NotNegative = 0.01
    """Speed at which the body returns to its height over ground that both feet found off the plan, m/s."""
    contact: ContactParameters = ContactParameters()
    attitude: AttitudeParameters = AttitudeParameters()
    fall: FallParameters = FallParameters()
    longest_gap: _Positive = 0.1
    """Longest time without an answer that reached the robot, beyond the usual delay, after which the walk goes
    on in stride, s; the plan makes up for it at once. After a longer one the walk goes on from a stand."""
