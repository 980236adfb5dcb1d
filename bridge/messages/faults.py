"""Faults of an emulated robot: in a scenario's TOML and, as part of a world command, live.

Numbers are in the unit of the disturbed quantity: rad, N, m/s^2, rad/s, degrees Celsius; durations in s.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from bridge.body.joints import JOINTS
from bridge.messages.frames import sensor_slots
from bridge.types import Bounded, Fraction
from bridge.validation import unknown_name

Cycles = Annotated[int, msgspec.Meta(ge=1, le=1000)]


class _Fault(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"):
    @property
    def name(self) -> str:
        """Kind and target; a new fault replaces the one with the same key."""
        kind = str(self.__struct_config__.tag)
        target = getattr(self, "sensor", None) or getattr(self, "joint", None)
        return f"{kind}:{target}" if target else kind


class CommandLost(_Fault, frozen=True, kw_only=True, tag="command-lost"):
    """A command never arrives."""

    probability: Fraction = 1.0


class CommandLate(_Fault, frozen=True, kw_only=True, tag="command-late"):
    """A command arrives some cycles later."""

    cycles: Cycles
    probability: Fraction = 1.0


class CommandDuplicated(_Fault, frozen=True, kw_only=True, tag="command-duplicated"):
    """A command arrives twice, some cycles apart; the last to arrive is in force."""

    cycles: Cycles = 1
    probability: Fraction = 1.0


class CommandReordered(_Fault, frozen=True, kw_only=True, tag="command-reordered"):
    """A command arrives after the next one and replaces it."""

    probability: Fraction = 1.0


class CommandJitter(_Fault, frozen=True, kw_only=True, tag="command-jitter"):
    """Each command arrives after a random number of cycles, uniform from 0 to `cycles`."""

    cycles: Cycles


class _SensorFault(_Fault, frozen=True, kw_only=True):
    sensor: str
    """Field of the sensor frame (`gyroscope`), or one element of it (`gyroscope.x`, `position.LKneePitch`,
    `fsr.LFL`)."""

    def __post_init__(self) -> None:
        """Raises ValueError for a sensor that a frame does not have."""
        sensor_slots(self.sensor)


class SensorStuck(_SensorFault, frozen=True, kw_only=True, tag="sensor-stuck"):
    """Repeats its value at the beginning of the fault."""


class SensorDead(_SensorFault, frozen=True, kw_only=True, tag="sensor-dead"):
    """Reads 0."""


class SensorNoisy(_SensorFault, frozen=True, kw_only=True, tag="sensor-noisy"):
    """Normally distributed noise on top."""

    deviation: Annotated[float, msgspec.Meta(ge=0.0, le=1e9)]


class SensorOffset(_SensorFault, frozen=True, kw_only=True, tag="sensor-offset"):
    """Reads too much by a constant."""

    offset: Bounded


class _JointFault(_Fault, frozen=True, kw_only=True):
    joint: str
    """Name of a joint; LHipYawPitch is the motor of both hips."""

    def __post_init__(self) -> None:
        """Raises ValueError for a joint that no frame has."""
        if self.joint not in JOINTS:
            raise ValueError(unknown_name("joint", self.joint, JOINTS))


class JointStuck(_JointFault, frozen=True, kw_only=True, tag="joint-stuck"):
    """The gear is jammed: the joint keeps its angle at the beginning of the fault."""


class JointWeak(_JointFault, frozen=True, kw_only=True, tag="joint-weak"):
    """The motor has only a fraction of its torque."""

    fraction: Fraction = 0.5


class JointLimp(_JointFault, frozen=True, kw_only=True, tag="joint-limp"):
    """The motor has no power: the joint gives way, with friction and the gear's drag alone; stiffness 0."""


class JointHot(_JointFault, frozen=True, kw_only=True, tag="joint-hot"):
    """The motor is held at a temperature; the robot lowers its stiffness as it would for a true one."""

    temperature: Annotated[float, msgspec.Meta(ge=-40.0, le=200.0)] = 95.0


class JointBacklash(_JointFault, frozen=True, kw_only=True, tag="joint-backlash"):
    """The gear has more backlash, added to the wear profile's: whole width of the dead zone, rad."""

    backlash: Annotated[float, msgspec.Meta(ge=0.0, le=0.5)]


class InertialRezero(_Fault, frozen=True, kw_only=True, tag="inertial-rezero"):
    """The inertial unit restarts: it takes the present attitude for upright until its filter has converged."""


class DcmPause(_Fault, frozen=True, kw_only=True, tag="dcm-pause"):
    """The DCM pauses: it sends no frames and takes no commands; the motor boards work."""


class PowerLoss(_Fault, frozen=True, kw_only=True, tag="power-loss"):
    """The motors have no power: all joints limp, stiffness 0, no charge; the head's computer works."""


class HalError(_Fault, frozen=True, kw_only=True, tag="hal-error"):
    """HAL misses its cycle: all joints limp, stiffness 0; frames and charge are unaffected."""


Fault = (
    CommandLost
    | CommandLate
    | CommandDuplicated
    | CommandReordered
    | CommandJitter
    | SensorStuck
    | SensorDead
    | SensorNoisy
    | SensorOffset
    | JointStuck
    | JointWeak
    | JointLimp
    | JointHot
    | JointBacklash
    | InertialRezero
    | DcmPause
    | HalError
    | PowerLoss
)
CommandFault = CommandLost | CommandLate | CommandDuplicated | CommandReordered | CommandJitter
SensorFault = SensorStuck | SensorDead | SensorNoisy | SensorOffset
JointFault = JointStuck | JointWeak | JointLimp | JointHot | JointBacklash
