"""The frames and messages of the contract, typed, in msgpack.

Arrays have fixed orders and lengths; units are SI; angles are radians. `docs/protocol.md` is the
specification of the same for other languages. Unknown fields are ignored, missing or ill-typed ones raise
`FrameError` naming the field.
"""

from __future__ import annotations

import math
import re
import sys
from typing import Annotated, Any, Final, Literal, Protocol, TypeVar

import msgspec

from bridge.errors import FrameError
from bridge.joints import JOINTS, N_JOINTS

SCHEMA_VERSION: Final = 1
"""Version of every message; a receiver refuses a version it does not know."""

MAX_PAYLOAD: Final = 65536
"""bytes; a receiver does not look into anything longer."""

NAME: Final = r"^[A-Za-z0-9_-]{1,64}(?!\n)$"
"""Ids of robots and names of controllers: they are parts of keys."""

_MAX_INT: Final = 2**63 - 1

Finite = Annotated[float, msgspec.Meta(ge=-sys.float_info.max, le=sys.float_info.max)]
"""Neither NaN nor infinite; an integer on the wire is taken for a float."""
Count = Annotated[int, msgspec.Meta(ge=0, le=_MAX_INT)]
Name = Annotated[str, msgspec.Meta(pattern=NAME)]
Joints = Annotated[tuple[Finite, ...], msgspec.Meta(min_length=N_JOINTS, max_length=N_JOINTS)]
"""25 floats in `bridge.joints.JOINTS` order."""
Vec2 = tuple[Finite, Finite]
Vec3 = tuple[Finite, Finite, Finite]
Quaternion = tuple[Finite, Finite, Finite, Finite]
"""(x, y, z, w)."""
Fsr = Annotated[tuple[Finite, ...], msgspec.Meta(min_length=8, max_length=8)]
"""Left foot FL, FR, RL, RR, then the right foot in the same order."""


class SensorFrame(msgspec.Struct, frozen=True, kw_only=True):
    """What the robot measures at the end of one DCM cycle (key `sensors`)."""

    version: int = SCHEMA_VERSION
    seq: Count
    """Cycle number, from 0 at the start or the last reset of the robot."""
    time: Finite
    """Robot time, s: `seq` times the cycle time (simulation time on the emulator)."""
    position: Joints
    """Measured joint angles, rad (hands: 0 closed .. 1 open)."""
    stiffness: Joints
    """Stiffness in force, 0..1 (share of the motor current limit), negative: free."""
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
    command: Annotated[int, msgspec.Meta(ge=-1, le=_MAX_INT)] = -1
    """`reply_to` of the actuator frame in force at this frame's cycle; -1 when none has come yet."""
    missed: Count = 0
    """Cycles, since `seq` 0, that a controller was expected to serve and did not in time."""
    wall: Count = 0
    """Wall clock of the robot side when the frame was sent, ns since the Unix epoch."""


class ActuatorFrame(msgspec.Struct, frozen=True, kw_only=True):
    """What the controller asks for (key `actuators`)."""

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


class Contact(msgspec.Struct, frozen=True, kw_only=True):
    """Ground reaction on one foot (ground truth)."""

    force: Vec3
    """Sum of the contact forces on the foot, world frame, N."""
    cop: Vec2 | None
    """Centre of pressure in the foot's sole frame (below the AnkleRoll origin), m; None without contact."""


class TruthFrame(msgspec.Struct, frozen=True, kw_only=True):
    """Ground truth of the emulator at one sensor frame (key `world/truth`); never seen by a controller."""

    version: int = SCHEMA_VERSION
    seq: Count
    time: Finite
    torso_position: Vec3
    """Torso frame origin, world frame, m."""
    torso_orientation: Quaternion
    torso_velocity: Vec3
    """Velocity of the Torso frame origin, world frame, m/s."""
    torso_angular_velocity: Vec3
    """World frame, rad/s."""
    joints: Joints
    """True joint angles, rad."""
    com: Vec3
    """Centre of mass, world frame, m."""
    zmp: Vec2 | None
    """Centre of pressure of both feet together on the ground, world frame x and y, m; None in flight."""
    left: Contact
    right: Contact
    fell: bool
    """Torso tilt over 45 deg, or torso below half its start height, or anything but a foot on the ground."""


class Info(msgspec.Struct, frozen=True, kw_only=True):
    """What a robot is and how its clock runs (query `info`)."""

    version: int = SCHEMA_VERSION
    robot: Name
    """Robot id: the second part of every key."""
    body: str
    """Data-sheet name, for example `nao-v3`."""
    side: str
    """`emulator`, `lola` or `naoqi`."""
    mode: str
    """`real-time` or `lockstep`."""
    cycle: Finite
    """Cycle time, s."""
    absent: tuple[str, ...]
    """Joints of the frame that this body does not have; their slots are ignored and read 0."""
    boot: Count
    """Number of this start of the robot process; a new number means that everything began anew."""
    software: str


class LeaseRequest(msgspec.Struct, frozen=True, kw_only=True):
    """Ask for, give back, or look at the lease (query `lease`)."""

    version: int = SCHEMA_VERSION
    op: Literal["acquire", "release", "status"]
    controller: Name
    """Name of the controller, also in its liveliness token."""
    ticket: Count = 0
    """Number that the controller drew at its start, also in its liveliness token, in hexadecimal: it tells two
    controllers of the same name apart."""


class LeaseReply(msgspec.Struct, frozen=True, kw_only=True):
    """Answer to a `LeaseRequest`."""

    version: int = SCHEMA_VERSION
    granted: bool
    lease: Count
    """The number to put into each actuator frame; 0 unless granted."""
    holder: str
    """Name of the controller that holds the lease now; empty when nobody does."""
    message: str


class Notice(msgspec.Struct, frozen=True, kw_only=True):
    """One sentence from the robot side about something it refused, changed or saw (key `notices`)."""

    version: int = SCHEMA_VERSION
    seq: Count
    level: str
    """`info`, `warning` or `error`."""
    code: str
    """Short stable name, for example `frame-refused`."""
    text: str


class WalkTelemetry(msgspec.Struct, frozen=True, kw_only=True):
    """What the walker is doing, for people and recordings (key `walk/telemetry`)."""

    version: int = SCHEMA_VERSION
    seq: Count
    """`seq` of the sensor frame it belongs to."""
    state: str
    """`approach`, `walk`, `stopping`, `stand` or `fallen`."""
    phase: str
    """`DSL`, `SSL`, `DSR`, `SSR`, `start`, `stop` or `stand`."""
    step: Count
    """Steps completed."""
    steps: Count
    """Steps asked for; 0: without end."""
    zmp: Vec2
    """Planned ZMP in the walk frame (x forward, y left, origin between the feet at the start), m."""
    com: Vec2
    """Planned centre of mass in the walk frame, m."""
    left: Vec3
    """Planned left sole in the walk frame, m."""
    right: Vec3
    angle: Vec2 = (0.0, 0.0)
    """Torso roll and pitch as the walker takes them, rad."""
    zmp_measured: Vec2 | None = None
    """ZMP from the force sensors in the walk frame, the feet taken to stand as planned, m; None unloaded."""
    contact: tuple[bool, bool] = (False, False)
    """Whether the left and the right foot touch the ground, by their force sensors."""
    foot_lift: Vec2 = (0.0, 0.0)
    """Height of the left and the right sole over the plan (leg admittance), m."""
    ankle_roll: Vec2 = (0.0, 0.0)
    """Added to LAnkleRoll and RAnkleRoll by the ankle admittance, rad."""
    ankle_pitch: Vec2 = (0.0, 0.0)
    """Added to LAnklePitch and RAnklePitch by the ankle admittance, rad."""
    torso_control: Vec2 = (0.0, 0.0)
    """Added to LAnklePitch and RAnklePitch by the torso control, rad."""
    tick: Finite = 0.0
    """Time the controller's tick took, s (0 in recordings that leave wall-clock values out)."""


Message = SensorFrame | ActuatorFrame | TruthFrame | Info | LeaseRequest | LeaseReply | Notice | WalkTelemetry


class Versioned(Protocol):
    """Any message: these, and those of other queries beside them."""

    @property
    def version(self) -> int:
        """Schema version it was written in."""


M = TypeVar("M", bound=Versioned)

_encoder = msgspec.msgpack.Encoder()
_decoders: dict[Any, msgspec.msgpack.Decoder[Any]] = {}


def encode(message: Versioned) -> bytes:
    """Msgpack map of a message, field names as keys."""
    return _encoder.encode(message)


def decode(payload: bytes, kind: type[M]) -> M:
    """A message of the given kind from msgpack.

    Raises:
        FrameError: not msgpack, too long, a missing, ill-typed, wrongly sized or non-finite field, or another
            schema version; the message names the field and what would be right.
    """
    message: M = decode_as(payload, kind, kind.__name__)
    return message


def decode_as(payload: bytes, kind: Any, name: str) -> Any:
    """As `decode`, for a union of messages too; `name` is what the errors call it."""
    if len(payload) > MAX_PAYLOAD:
        raise FrameError(f"{name} refused: {len(payload)} bytes; at most {MAX_PAYLOAD} are allowed.")
    try:
        message = _decoder(kind).decode(payload)
    except msgspec.ValidationError as error:
        _require_version(name, payload)
        raise FrameError(f"{name} refused: {_in_words(str(error))}.") from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FrameError(
            f"{name} refused: {len(payload)} bytes that are not one whole msgpack map ({error})."
        ) from None
    if message.version != SCHEMA_VERSION:
        raise _other_version(name, message.version)
    return message


def _decoder(kind: Any) -> msgspec.msgpack.Decoder[Any]:
    decoder = _decoders.get(kind)
    if decoder is None:
        decoder = _decoders[kind] = msgspec.msgpack.Decoder(kind)
    return decoder


class _Head(msgspec.Struct):
    """What all versions of all messages have in common."""

    version: int = SCHEMA_VERSION


def _require_version(name: str, payload: bytes) -> None:
    """Blame the version rather than a field, when a message of another version does not fit."""
    try:
        version = _decoder(_Head).decode(payload).version
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return
    if version != SCHEMA_VERSION:
        raise _other_version(name, version)


def _other_version(name: str, version: int) -> FrameError:
    return FrameError(f"{name} refused: schema version {version}; this side speaks {SCHEMA_VERSION}.")


_PLACE: Final = re.compile(r"(?P<reason>.*) - at `\$\.?(?P<path>.*)`", re.DOTALL)
_SLOT: Final = re.compile(r"(?:position|stiffness|current|temperature|joints)\[(\d+)\]")
_IN_WORDS: Final = (
    # the bounds of all numbers, which are to keep infinities out; others say what they are
    (re.compile(r"Expected `float` [<>]= -?(?:\d{9,}\.0|\d[.\d]*e\+?\d+).*"), "a finite number is expected"),
    (re.compile(r"Expected `(?:float|int)` ([<>]=? \S+).*"), r"a number \1 is expected"),
    (
        re.compile(r"Expected `array` of (?:at least |at most )?length (?:[<>]= )?(\d+).*"),
        r"\1 elements are expected",
    ),
    (
        re.compile(r"Expected `str` matching regex .*", re.DOTALL),
        "1 to 64 letters, digits, `_` or `-` are expected",
    ),
    (
        re.compile(r"(Invalid enum value '[^']{,40}).*", re.DOTALL),
        r"\1'; `acquire`, `release` or `status` is expected",
    ),
    (re.compile(r"Expected `object`(.*)"), r"a map is expected\1"),
)


def _in_words(error: str) -> str:
    """A decoder's complaint with the field in front, and the joint's name beside its slot."""
    found = _PLACE.fullmatch(error)
    reason = found["reason"] if found else error
    for pattern, words in _IN_WORDS:
        reason = pattern.sub(words, reason)
    return f"{_place(found['path'])}: {reason[:300]}" if found else reason[:300]


def _place(path: str) -> str:
    slot = _SLOT.fullmatch(path)
    return (
        f"`{path}` ({JOINTS[int(slot[1])]})" if slot and int(slot[1]) < N_JOINTS else f"`{path or 'message'}`"
    )


def require_finite(name: str, values: tuple[float, ...]) -> None:
    """For frames that never were on a wire: raise `FrameError` at the first value that is NaN or infinite.

    Args:
        name: field, one of those in joint order.
        values: 25 of them.
    """
    for i, value in enumerate(values):
        if not math.isfinite(value):
            raise FrameError(
                f"ActuatorFrame refused: {_place(f'{name}[{i}]')} is {value}; a finite number is expected."
            )
