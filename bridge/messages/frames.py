"""The two frames of a cycle: sensor values up, joint angles and stiffnesses down."""

from __future__ import annotations

from typing import Annotated

import msgspec

from bridge.body.joints import N_JOINTS
from bridge.messages.schema import SCHEMA_VERSION
from bridge.types import MAX_INT, Count, Finite, Vec2, Vec3

Joints = Annotated[tuple[Finite, ...], msgspec.Meta(min_length=N_JOINTS, max_length=N_JOINTS)]
"""25 floats in `bridge.body.joints.JOINTS` order."""
Fsr = Annotated[tuple[Finite, ...], msgspec.Meta(min_length=8, max_length=8)]
"""Left foot FL, FR, RL, RR, then the right foot in the same order."""


N_LEDS = 89
Leds = Annotated[
    tuple[Annotated[int, msgspec.Meta(ge=0, le=255)], ...], msgspec.Meta(min_length=N_LEDS, max_length=N_LEDS)
]
"""Brightness of each LED, 0 to 255, in the order of `bridge.dcm.actuators.led_names`."""


class SensorFrame(msgspec.Struct, frozen=True, kw_only=True):
    """Measurements at the end of one DCM cycle (key `sensors`)."""

    version: int = SCHEMA_VERSION
    seq: Count
    """Cycle number, from 0 at the start or the last reset of the robot."""
    time: Finite
    """Robot time, s: `seq` times the cycle time (simulation time on the emulator)."""
    position: Joints
    """Measured joint angles, rad (hands: 0 closed .. 1 open)."""
    stiffness: Joints
    """Stiffness in force, 0..1 (fraction of the motor current limit), negative: free."""
    current: Joints
    """Motor currents, A, absolute values."""
    temperature: Joints
    """Motor temperatures, degrees Celsius."""
    fsr: Fsr
    """Force on each foot sensor along the sole normal, N."""
    accelerometer: Vec3
    """Specific force in the Torso frame, m/s^2: upright at rest (0, 0, +9.81)."""
    gyroscope: Vec3
    """Angular velocity in the Torso frame, rad/s, right-handed."""
    angle: Vec2
    """Fused torso AngleX (roll) and AngleY (pitch), rad."""
    touch: Annotated[tuple[Finite, ...], msgspec.Meta(min_length=14, max_length=14)]
    """Buttons, 0 or 1, in LoLA's order: chest, head front, middle, rear, left foot bumper left, right,
    left hand back, left, right, right foot bumper left, right, right hand back, left, right."""
    battery: Annotated[tuple[Finite, ...], msgspec.Meta(min_length=4, max_length=4)]
    """Charge (0..1), current (A), status, temperature (degrees Celsius)."""
    sonar: Vec2
    """Left and right distance, m."""
    command: Annotated[int, msgspec.Meta(ge=-1, le=MAX_INT)] = -1
    """`reply_to` of the actuator frame in force at this frame's cycle; -1 when none has come yet."""
    missed: Count = 0
    """Cycles, since `seq` 0, that a controller was expected to serve and did not in time."""
    wall: Count = 0
    """Wall clock of the robot side when the frame was sent, ns since the Unix epoch."""


class ActuatorFrame(msgspec.Struct, frozen=True, kw_only=True):
    """Commands of the controller (key `actuators`)."""

    version: int = SCHEMA_VERSION
    reply_to: Count
    """`seq` of the sensor frame this answers."""
    lease: Count = 0
    """Number that the robot gave with the lease; 0 in process, where there is none."""
    position: Joints
    """Wanted joint angles, rad (hands: 0..1)."""
    stiffness: Joints
    """Wanted stiffness, 0..1; negative: free."""
    wall: Count = 0
    """Wall clock of the controller when the frame was sent, ns since the Unix epoch."""


class LedFrame(msgspec.Struct, frozen=True, kw_only=True):
    """Lights of an emulated robot (key `leds`): they move nothing, and need no lease."""

    version: int = SCHEMA_VERSION
    leds: Leds
