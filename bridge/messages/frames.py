"""The two frames of a cycle, sensor values up and joint targets down, and the names of their elements.

Also the description of the robot that sends them (query `info`), and its notices (key `notices`).
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

import msgspec

from bridge.body.joints import JOINTS, N_JOINTS
from bridge.types import MAX_INT, Count, Finite, Vec2, Vec3
from bridge.validation import unknown_name

SCHEMA_VERSION: Final = 3
"""Version of every message; a receiver refuses a version it does not know."""

MAX_PAYLOAD: Final = 65536
"""bytes; a receiver refuses longer ones."""

NAME: Final = r"^[A-Za-z0-9_-]{1,64}(?!\n)$"
"""Ids of robots, names of controllers and of boxes."""

Name = Annotated[str, msgspec.Meta(pattern=NAME)]


class Versioned(Protocol):
    """Any message."""

    @property
    def version(self) -> int:
        """Its schema version."""


_CELLS: Final = ("LFL", "LFR", "LRL", "LRR", "RFL", "RFR", "RRL", "RRR")
_BUTTONS: Final = (
    *("chest", "head_front", "head_middle", "head_rear", "left_bumper_left", "left_bumper_right"),
    *("left_hand_back", "left_hand_left", "left_hand_right", "right_bumper_left", "right_bumper_right"),
    *("right_hand_back", "right_hand_left", "right_hand_right"),
)
ELEMENTS: Final[dict[str, tuple[str, ...]]] = {
    "position": JOINTS,
    "stiffness": JOINTS,
    "current": JOINTS,
    "temperature": JOINTS,
    "fsr": _CELLS,
    "accelerometer": ("x", "y", "z"),
    "gyroscope": ("x", "y", "z"),
    "angle": ("x", "y"),
    "touch": _BUTTONS,
    "battery": ("charge", "current", "status", "temperature"),
    "sonar": ("left", "right"),
}
"""Fields of `SensorFrame` that a fault can disturb, and the names of their elements in order."""


def sensor_slots(sensor: str) -> tuple[str, tuple[int, ...]]:
    """Field and indices of a selector of sensors.

    Raises:
        ValueError: no such field or element; names the nearest one there is.
    """
    field, _, element = sensor.partition(".")
    if field not in ELEMENTS:
        raise ValueError(unknown_name("sensor", field, ELEMENTS))
    names = ELEMENTS[field]
    if not element:
        return field, tuple(range(len(names)))
    if element not in names:
        raise ValueError(unknown_name(f"element of `{field}`", element, names))
    return field, (names.index(element),)


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
    """`reply_to` of the actuator frame in force at this frame's cycle; -1: none yet."""
    missed: Count = 0
    """Expected answers that were not in time since `seq` 0, cycles."""
    wall: Count = 0
    """Wall clock of the robot side at the sending, ns since the Unix epoch."""


class ActuatorFrame(msgspec.Struct, frozen=True, kw_only=True):
    """Commands of the controller (key `actuators`)."""

    version: int = SCHEMA_VERSION
    reply_to: Count
    """`seq` of the sensor frame this answers."""
    lease: Count = 0
    """Number of the lease; 0 in process, where there is none."""
    position: Joints
    """Wanted joint angles, rad (hands: 0..1)."""
    stiffness: Joints
    """Wanted stiffness, 0..1; negative: free."""
    wall: Count = 0
    """Wall clock of the controller at the sending, ns since the Unix epoch."""


class LedFrame(msgspec.Struct, frozen=True, kw_only=True):
    """Lights of an emulated robot (key `leds`); no lease is needed."""

    version: int = SCHEMA_VERSION
    leds: Leds


class Info(msgspec.Struct, frozen=True, kw_only=True):
    """Description of a robot and of its clock (query `info`)."""

    version: int = SCHEMA_VERSION
    robot: Name
    """Robot id: the second part of every key."""
    body: str
    """Data-sheet name, for example `nao-v3`."""
    sheet: str = ""
    """The whole data sheet, JSON, of a body that is not shipped; see `bridge.body.body_of`."""
    side: str
    """`emulator`, `lola` or `naoqi`."""
    mode: str
    """`real-time` or `lockstep`."""
    cycle: Finite
    """Cycle time, s."""
    absent: tuple[str, ...]
    """Joints of the frame that this body does not have; their slots are ignored and read 0."""
    boot: Count
    """Number of this start of the robot process; a new number means that the robot restarted."""
    software: str
    limits: tuple[tuple[Finite, Finite], ...] = ()
    """Range of each slot of the frame, rad (hands: 0 to 1); 0, 0 for a joint that the body lacks."""
    actuators: tuple[str, ...] = ()
    """Names that `dcm/createAlias` and `dcm/set` know."""
    stand: tuple[Finite, ...] = ()
    """The published posture StandInit inside these ranges, 25 positions, rad."""
    crouch: tuple[Finite, ...] = ()
    """The published posture Crouch inside these ranges, 25 positions, rad."""


ORDER: Final = "order"
"""Code of a walker's notice of an order that changes what it does."""


class Notice(msgspec.Struct, frozen=True, kw_only=True):
    """One sentence of the robot side about a refusal, a change or an event (key `notices`)."""

    version: int = SCHEMA_VERSION
    seq: Count
    level: str
    """`info`, `warning` or `error`."""
    code: str
    """Short stable name, for example `frame-refused`."""
    text: str

    @property
    def routine(self) -> bool:
        """The guard follows a new controller or holds after a release; the walker has an order."""
        return self.code in ("guard-active", ORDER) or (self.code == "guard-hold" and self.level == "info")
