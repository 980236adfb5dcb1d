"""Commands to the world of an emulated robot (query `world/command`).

A command is a msgpack map with its name as `op`. Lengths in m, angles in rad, impulses in N s.
The floor frame has its origin on the floor at the start of the run and turns with the floor; the heading frame
has the torso's heading: x forward, y left, z vertical.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, Literal

import msgspec

from bridge.errors import FrameError
from bridge.messages.codec import decode_command, encode
from bridge.messages.faults import Fault
from bridge.messages.frames import SCHEMA_VERSION, Name
from bridge.messages.game import GameReport
from bridge.types import Bounded, Vec3

WORLD_COMMAND = "world/command"
"""Key suffix of the query."""
MAX_TILT = 0.6
"""Steepest floor, rad."""
MAX_TILT_RATE = 0.35
"""Fastest turn of the floor, rad/s: a faster one strikes the feet."""
MAX_IMPULSE: Final = 100.0
"""Largest push along an axis, N s: it gives a NAO of 5.4 kg 18 m/s."""

Length = Annotated[float, msgspec.Meta(ge=1e-3, le=100.0)]
Size = tuple[Length, Length, Length]
Angle = Annotated[float, msgspec.Meta(ge=-100.0, le=100.0)]
Tilt = Annotated[float, msgspec.Meta(ge=-MAX_TILT, le=MAX_TILT)]
Friction = Annotated[float, msgspec.Meta(ge=0.0, le=10.0)]
Impulse = Annotated[float, msgspec.Meta(ge=-MAX_IMPULSE, le=MAX_IMPULSE)]
Mass = Annotated[float, msgspec.Meta(ge=0.0, le=1000.0)]
MIN_MASS: Final = 1e-3
"""Least mass of a movable object, kg."""
Duration = Annotated[float, msgspec.Meta(ge=0.0, le=3600.0)]
Foot = Literal["left", "right", "swing"]
ThingKind = Literal["ball", "landmark", "face"]
THING_SIZES: Final[dict[str, float]] = {"ball": 0.06, "landmark": 0.1, "face": 0.15}
"""Diameter of a thing unless another is given, m: the vendor's red ball; landmark and face are assumed."""
THING_HEIGHT: Final = 0.45
"""Height of the middle of a landmark or a face over the floor unless another is given, m: a NAO's eyes."""
StartName = Literal["stand", "sit", "crouch", "lie-back", "lie-front", "lie-side", "hang"]
"""Poses to begin in. `stand`: on its feet, stiff; `hang`: the torso on a hook, feet in the air."""


class _Command(msgspec.Struct, frozen=True, kw_only=True, tag_field="op"):
    version: int = SCHEMA_VERSION


class Status(_Command, frozen=True, kw_only=True, tag="status"):
    """Report the world's state and change nothing."""

    terrain: bool = False
    """Also fill `WorldReply.terrain`, which is constant until a reset."""


class Reset(_Command, frozen=True, kw_only=True, tag="reset"):
    """Restart: same posture, same scenario, same seed, `seq` 0; live changes are undone."""

    scope: Literal["world", "robot"] = "world"
    """`world`: all robots of it. `robot`: this one alone, at its start without faults; clock, events, objects
    and the other robots go on."""


class Pause(_Command, frozen=True, kw_only=True, tag="pause"):
    """Hold the world and its clock."""


class Resume(_Command, frozen=True, kw_only=True, tag="resume"):
    """End a pause."""


class Step(_Command, frozen=True, kw_only=True, tag="step"):
    """Run some cycles and pause; answered after the last one."""

    cycles: Annotated[int, msgspec.Meta(ge=1, le=100_000)] = 1


class LayDown(_Command, frozen=True, kw_only=True, tag="lay-down"):
    """Put the robot into a start pose in place, without stiffness where a real robot would have none."""

    pose: StartName = "lie-back"


class StandUp(_Command, frozen=True, kw_only=True, tag="stand-up"):
    """Put the lying robot on its feet at its present place, stiff in its start posture.

    Refused for a robot that is on its feet and under command.
    """


class Push(_Command, frozen=True, kw_only=True, tag="push"):
    """Push a link of the robot, or a movable box, at its centre of mass with a constant force."""

    impulse: tuple[Impulse, Impulse, Impulse]
    """Heading frame, N s; the force is this over the duration."""
    duration: Annotated[float, msgspec.Meta(ge=0.0, le=60.0)] = 0.1
    """s, rounded to physics steps, at least one."""
    target: str = "Torso"
    """`Torso`, the joint that moves the link, or the name of a movable box."""


SolidShape = Literal["box", "ball", "pole"]
"""A pole is an upright cylinder."""


LEAGUE_BALL_DIAMETER: Final = 0.1
"""Diameter of the Standard Platform League's ball, m (rules since 2016; Webots' `SPLBall`)."""
LEAGUE_BALL_MASS: Final = 0.044
"""kg; likewise."""


class PlaceObject(_Command, frozen=True, kw_only=True, tag="place"):
    """Put an object: a box (a plate, a step, a wall), a ball or a pole, fixed or movable."""

    name: Name
    """An object of the same name is replaced."""
    shape: SolidShape = "box"
    size: Size
    """Along its x, y and z, m; of a ball three times its diameter."""
    at: tuple[Bounded, Bounded]
    """Middle of its bottom, m."""
    yaw: Angle = 0.0
    frame: Literal["floor", "robot"] = "floor"
    """`at` and `yaw` in the floor frame, or from the floor point under the torso in its heading."""
    height: Bounded | None = None
    """Height of its bottom over the floor, m; None: it lies on the ground or on an object."""
    mass: Mass = 0.0
    """kg; 0: fixed to the floor."""
    friction: Friction | None = None
    """Against the robot's soles; None: as the floor."""


class PlaceThing(_Command, frozen=True, kw_only=True, tag="thing"):
    """Put a thing that is visible to the cameras and has no contacts."""

    name: Name
    """A thing of the same name is replaced. Of a landmark its number; of a face the person's name."""
    kind: ThingKind
    """`ball`: a red one. `landmark`: a disc with a mark. `face`: a disc with a face."""
    at: tuple[Bounded, Bounded]
    """Place of its middle, m."""
    height: Bounded | None = None
    """Height of its middle over the floor, m; None: 0 under a ball, `THING_HEIGHT` for the others."""
    yaw: Angle | None = None
    """Heading to which a landmark or a face shows its front; None: towards the robot."""
    frame: Literal["floor", "robot"] = "floor"
    """`at` and `yaw` as those of `PlaceObject`."""
    size: Length | None = None
    """Diameter, m; None: as in `THING_SIZES`."""


class Remove(_Command, frozen=True, kw_only=True, tag="remove"):
    """Take a box or a thing away."""

    name: Name


class PlateUnderFoot(_Command, frozen=True, kw_only=True, tag="plate-under-foot"):
    """Put a plate on the floor under a foot as soon as that foot is high enough over the floor."""

    foot: Foot = "swing"
    """`swing`: the first foot to be lifted."""
    size: Size = (0.16, 0.08, 0.01)
    """m; narrow enough to miss the other foot, 0.1 m to the side."""
    shift: tuple[Bounded, Bounded] = (0.0, 0.0)
    """From the middle of the sole's projection, along its heading and to its left, m: a lifted foot lands ahead
    of its liftoff pose."""
    yaw: Angle = 0.0
    """Angle of the plate's length against the foot's heading, rad."""
    name: Name = "plate"


class SwingPendulum(_Command, frozen=True, kw_only=True, tag="pendulum"):
    """Release a pendulum against the robot, as in benchmarks of pushes: a bob on a light rod.

    It begins at rest, strikes at its lowest point, and disappears half a period after its release.
    """

    mass: Annotated[float, msgspec.Meta(gt=0.0, le=1000.0)]
    """Mass of the bob, kg."""
    length: Annotated[float, msgspec.Meta(gt=0.05, le=10.0)] = 1.0
    """From the pivot to the middle of the bob, m."""
    angle: Annotated[float, msgspec.Meta(gt=0.0, le=1.5)]
    """At the release, from the vertical, rad."""
    direction: Angle = 0.0
    """In which the bob moves when it strikes, from the torso's heading to the left, rad."""
    height: Annotated[float, msgspec.Meta(gt=0.0, le=2.0)] | None = None
    """Height of the strike over the floor, m; None: the torso's centre of mass."""


class TiltFloor(_Command, frozen=True, kw_only=True, tag="tilt"):
    """Turn the floor, with all that is fixed on it, about the point under the torso."""

    roll: Tilt = 0.0
    """About x, right-handed, rad: positive raises the left."""
    pitch: Tilt = 0.0
    """About y, right-handed, rad: positive lowers the front. The floor's orientation is Ry(pitch) Rx(roll)."""
    duration: Duration = 1.0
    """s; smooth at both ends."""


class SetFriction(_Command, frozen=True, kw_only=True, tag="friction"):
    """Change the floor's friction, and that of all fixed boxes without their own."""

    friction: Friction


class StartFault(_Command, frozen=True, kw_only=True, tag="fault-on"):
    """Begin a fault; one of the same kind and target is replaced."""

    fault: Fault
    duration: Duration = 0.0
    """s; 0: until it is ended or the world is reset."""


class EndFault(_Command, frozen=True, kw_only=True, tag="fault-off"):
    """End a fault by its name in the answer to `fault-on`, for example `joint-weak:LKneePitch`; empty: all."""

    name: str = ""


class Press(_Command, frozen=True, kw_only=True, tag="press"):
    """Press or release a button, bumper or touch surface."""

    button: str
    """As in `bridge.messages.frames.ELEMENTS["touch"]`, for example `chest`."""
    pressed: bool = True


class ReportGame(_Command, frozen=True, kw_only=True, tag="game"):
    """Report the league's game to all robots of the world that play in it, as the GameController does."""

    game: GameReport


WorldCommand = (
    Status
    | Reset
    | Pause
    | Resume
    | Step
    | StandUp
    | LayDown
    | Push
    | PlaceObject
    | PlaceThing
    | Remove
    | PlateUnderFoot
    | SwingPendulum
    | TiltFloor
    | SetFriction
    | StartFault
    | EndFault
    | Press
    | ReportGame
)


def solid_fault(shape: SolidShape, size: Vec3, mass: float) -> str:
    """Why there is no object of this shape, edges (m) and mass (kg), in one sentence; empty: there is one."""
    x, y, z = size
    if 0.0 < mass < MIN_MASS:
        return f"The mass is {mass:g} kg; 0 fixes an object, {MIN_MASS:g} kg is the least that moves."
    if shape != "box" and (x != y or (shape == "ball" and x != z)):
        right = "its diameter, three times" if shape == "ball" else "its diameter, twice, and its height"
        return f"The size of a {shape} is {right}, not {x:g} x {y:g} x {z:g} m."
    if shape == "ball" and mass <= 0.0:
        return f"A ball rolls and needs a mass; that of the league has {LEAGUE_BALL_MASS:g} kg."
    return ""


def require_command(command: object) -> None:
    """See that a command that was made in this process could be sent: Python checks no bounds.

    Raises:
        FrameError: no command to the world, or one with a wrong value; names the field.
    """
    if not isinstance(command, _Command):
        raise FrameError(
            f"World command refused: {command!r:.80} is none; give one of `bridge.messages.world`."
        )
    try:
        payload = encode(command)
    except TypeError as error:
        raise FrameError(f"World command refused: {error}; numbers, text and tuples are expected.") from None
    decode_command(payload, WorldCommand, "World command")


def min_tilt_duration(turn: float) -> float:
    """Shortest time in which the floor may turn by an angle (rad), s; smooth at both ends."""
    # the steepest part of the cosine is pi/2 over the mean
    return 0.5 * math.pi * turn / MAX_TILT_RATE
