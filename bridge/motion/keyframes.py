"""Key-frame motions: their file format, and their 25 angles on a body.

A motion moves the joints from frame to frame in straight lines in joint space, each in its time. Joints that a
frame leaves out stay as they are, before their first frame at the robot's present targets. The first frame is
approached from any pose.
"""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Annotated, Any, Final, Literal, NamedTuple

import msgspec

from bridge.body import Body
from bridge.body.joints import INDEX, INDEX_WITH_MIRROR, JOINTS, degrees_warning
from bridge.body.quantities import absent_joints, limits
from bridge.config import MAX_TOML_SIZE, load_toml
from bridge.errors import ConfigurationError
from bridge.files import Row, read_table
from bridge.types import Fraction, NotNegative, Positive
from bridge.validation import Invalid, convert, unknown_name

Lying = Literal["back", "front", "left", "right", "upright"]
"""Side on which the robot lies: back, front, left or right; `upright`: it stands or sits."""
_FOLDER: Final = Path(__file__).parent
_MIDLINE_JOINTS: Final = ("HeadPitch", "LHipYawPitch")
"""Joints without a side that stay as they are in a mirror; HeadYaw turns round."""
_TABLE_COLUMNS: Final = ("duration_s", "stiffness")
"""Columns of a table, in addition to the joints' columns."""
_RIGHT: Final = f"give a CSV file of key frames, of at most {MAX_TOML_SIZE} bytes"
_APPROACH_SPEED: Final = 1.5708
"""rad/s; speed of the approach to the first frame, NaoTH's."""


class _Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base: frozen, and a misspelt key is an error."""


class Frame(_Table, frozen=True, kw_only=True):
    """A pose of the joints and its time."""

    duration: NotNegative
    """Time from the frame before, s; of the first frame of a motion the least, an approach takes longer."""
    joints: dict[str, float] = {}
    """rad, by name; those left out stay. `RHipYawPitch` is the motor of `LHipYawPitch`, whose angle counts."""
    stiffness: Fraction | None = None
    """Stiffness of all joints; None: as before."""


class Gate(_Table, frozen=True, kw_only=True):
    """Range of the torso's angles without which the motion fails."""

    pitch: tuple[float, float] = (-3.2, 3.2)
    """Fused torso pitch, rad."""
    roll: tuple[float, float] = (-3.2, 3.2)
    """Fused torso roll, rad."""
    wait: NotNegative = 0.0
    """Time for the torso to reach it, s."""


class Phase(_Table, frozen=True, kw_only=True):
    """Frames that are played together."""

    frames: tuple[Frame, ...]
    repeat: Annotated[int, msgspec.Meta(ge=1, le=100)] = 1
    mirrored: bool = False
    """Left and right change places."""
    gate: Gate | None = None
    """At the end of the phase."""


class Motion(_Table, frozen=True, kw_only=True):
    """A key-frame motion; the content of a file."""

    title: str
    source: str
    """Origin of the angles, and their licence."""
    begins: Annotated[tuple[Lying, ...], msgspec.Meta(min_length=1)] = (
        "upright",
        "back",
        "front",
        "left",
        "right",
    )
    """Lying sides at which it may begin; the first is the usual one."""
    bodies: tuple[str, ...] = ()
    """On which the motion works; empty: unknown."""
    gets_up: bool = False
    """A motion for getting up after a fall."""
    approach_speed: Positive = _APPROACH_SPEED
    """Largest speed of the fastest joint on the way to the first frame, rad/s."""
    ankle_gyroscope: float = 0.0
    """rad of both AnklePitch per rad/s of the low-passed gyroscope about y."""
    hip_gyroscope: float = 0.0
    """The same of both HipPitch."""
    phases: tuple[Phase, ...]


class KeyFrameTarget(NamedTuple):
    """One frame of a motion on a body."""

    duration: float
    """Time to reach this frame, s."""
    position: dict[int, float]
    """By frame slot, of the joints named so far, rad."""
    stiffness: float
    gate: Gate | None


def motion_names() -> tuple[str, ...]:
    """Names of the package's motions."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def load_motion(name_or_path: str, also: tuple[str, ...] = ()) -> Motion:
    """A motion by its name, or from a file (.toml, or .csv with a header of joint names).

    Args:
        name_or_path: name of a motion, or path of a file.
        also: further names that the caller takes, for the error sentence.

    Raises:
        ConfigurationError: no such motion, or a file that is none.
    """
    path = Path(name_or_path)
    if path.suffix not in (".csv", ".toml"):
        if name_or_path not in motion_names():
            known = (*also, *motion_names())
            raise ConfigurationError(f"{unknown_name('motion', name_or_path, known)}, or a file")
        path = _FOLDER / f"{name_or_path}.toml"
    motion = read_csv(path) if path.suffix == ".csv" else load_toml(path, Motion)
    for phase in motion.phases:
        _check_gate(path, phase.gate or Gate())
        for joint, angle in (item for frame in phase.frames for item in frame.joints.items()):
            if joint not in INDEX_WITH_MIRROR:
                raise ConfigurationError(f"{path}: {unknown_name('joint', joint, JOINTS)}")
            if why := degrees_warning(joint, angle):
                raise ConfigurationError(f"{path}: {why}")
    if not any(phase.frames for phase in motion.phases):
        raise ConfigurationError(f"{path}: no key frames; at least one is expected")
    return motion


def _check_gate(path: Path, gate: Gate) -> None:
    """Raises ConfigurationError on bounds in the wrong order."""
    for axis in ("pitch", "roll"):
        low, high = getattr(gate, axis)
        if low > high:
            raise ConfigurationError(f"{path}: gate.{axis} = [{low:g}, {high:g}]: the lower bound comes first")


def motion_for(kind: str, body: Body) -> Motion | None:
    """The package's motion of a kind for a body; None: there is none.

    Args:
        kind: beginning of its name, for example `sit-down`.
        body: data sheet.
    """
    motions = (load_motion(name) for name in motion_names() if name.startswith(kind))
    return next((motion for motion in motions if not motion.bodies or body.base in motion.bodies), None)


def named_motion(name: str, body: Body, also: tuple[str, ...] = ()) -> Motion:
    """The package's motion of a name, in the body's own version.

    Args:
        name: for example `sit-down`.
        body: data sheet.
        also: further names that the caller takes, for the error sentence.

    Raises:
        ConfigurationError: no such motion, or none for this body.
    """
    if name not in motion_names():
        raise ConfigurationError(unknown_name("motion", name, (*also, *motion_names())))
    motion = motion_for(name, body)
    if motion is None:
        works = ", ".join(load_motion(name).bodies)
        raise ConfigurationError(f"the motion {name} works on {works}, not on {body.name}")
    return motion


def read_csv(path: Path) -> Motion:
    """A motion from a table: columns `duration_s`, `stiffness` and joint names (rad); an empty cell: as before.

    Columns of other names are left out, unless they resemble a joint's.

    Raises:
        ConfigurationError: unreadable, without such columns, or a cell is no such number.
    """
    first, *rows = [*read_table(path, _RIGHT, limit=MAX_TOML_SIZE)] or [Row(1, [])]
    columns = first.cells
    for needed in _TABLE_COLUMNS:
        if needed not in columns:
            raise ConfigurationError(f"{path}: no column {needed}; columns are separated by commas")
    for number, column in enumerate(columns):  # others may be notes
        if column in columns[:number] and column in (*_TABLE_COLUMNS, *INDEX_WITH_MIRROR):
            raise ConfigurationError(f"{path}: the column {column} is there twice")
        if column not in INDEX_WITH_MIRROR and difflib.get_close_matches(column, JOINTS, cutoff=0.8):
            raise ConfigurationError(f"{path}: {unknown_name('joint', column, JOINTS)}")
    frames = tuple(
        _frame(dict(zip(columns, row.cells, strict=True)), f"{path}, line {row.line}") for row in rows
    )
    return Motion(title=path.stem, source=str(path.name), phases=(Phase(frames=frames),))


def _frame(row: dict[str, str], place: str) -> Frame:
    """A row of a table.

    Args:
        row: cells by their columns.
        place: file and line, for errors.

    Raises:
        ConfigurationError: a cell is no such number.
    """

    def number(column: str, kind: Any) -> float:
        """Value of a column, as a number of a kind."""
        try:
            value: float = convert(float(row[column]), kind)
        except Invalid as error:
            raise ConfigurationError(f"{place}, column {column}: {error.reason}") from None
        except ValueError:
            raise ConfigurationError(f"{place}, column {column}: {row[column]!r} is no number") from None
        return value

    return Frame(
        duration=number("duration_s", NotNegative),
        joints={joint: number(joint, float) for joint in INDEX_WITH_MIRROR if row.get(joint)},
        stiffness=number("stiffness", Fraction) if row.get("stiffness") else None,
    )


def mirrored(motion: Motion) -> Motion:
    """The mirror image of a motion: left and right change places."""
    phases = tuple(msgspec.structs.replace(phase, mirrored=not phase.mirrored) for phase in motion.phases)
    return msgspec.structs.replace(motion, phases=phases)


def targets(motion: Motion, body: Body) -> list[KeyFrameTarget]:
    """The frames of a motion in order, inside the joints' ranges."""
    position: dict[int, float] = {}
    stiffness, found = 1.0, []
    absent = absent_joints(body)
    for phase in motion.phases:
        frames = phase.frames * phase.repeat
        for number, frame in enumerate(frames, 1):
            joints = {"LHipYawPitch" if name == "RHipYawPitch" else name: q for name, q in frame.joints.items()}
            joints |= {name: q for name, q in frame.joints.items() if name == "LHipYawPitch"}
            if phase.mirrored:
                joints = {_mirror(name): _sign(name) * angle for name, angle in joints.items()}
            for joint, angle in joints.items():
                if joint not in absent:
                    lower, upper = limits(body, joint)
                    position = position | {INDEX[joint]: min(max(angle, lower), upper)}
            stiffness = stiffness if frame.stiffness is None else frame.stiffness
            gate = phase.gate if number == len(frames) else None
            found.append(KeyFrameTarget(frame.duration, position, stiffness, gate))
    return found


def _mirror(joint: str) -> str:
    """The joint on the other side."""
    if joint in _MIDLINE_JOINTS or joint[0] not in "LR":
        return joint
    return ("R" if joint[0] == "L" else "L") + joint[1:]


def _sign(joint: str) -> float:
    """Sign of the angle in a mirror: yaw and roll turn round, pitch stays."""
    turns = joint.endswith(("Roll", "Yaw")) and joint not in _MIDLINE_JOINTS
    return -1.0 if turns else 1.0
