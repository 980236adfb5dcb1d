"""Log files of B-Human's software (.log), by the specification of types that each log holds itself.

Source: `LogPlayer`, `TypeInfo`, `MessageQueue` of B-Human's code releases. A file is a sequence of chunks, each
after a byte for its kind: settings of the robot, names of the messages' ids, specification of all types, and
the messages. Logs of the releases since 2014 have a specification.
"""

from __future__ import annotations

import re
import struct
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.body.joints import INDEX, JOINTS
from bridge.body.quantities import GRAVITY
from bridge.errors import ConfigurationError
from bridge.files import read_limited
from bridge.messages.frames import ELEMENTS
from bridge.types import Array
from nao_hil.identification.readings import LoggedRun, specific_force

_UNCOMPRESSED, _COMPRESSED, _MESSAGE_IDS, _TYPES, _SETTINGS = range(5)
"""Kinds of chunks."""
_UNIFIED: Final = 0x8000_0000
"""Bit in the number of primitive types: the names of types are unified already."""
_OPEN: Final = 0x0FFF_FFFF
"""Number of messages of a log that is not closed: all up to the end of the file."""
_HEADER: Final = struct.Struct("<II")
_CODES: Final = {
    **{"bool": "?", "char": "b", "signed char": "b", "unsigned char": "B", "short": "h", "unsigned short": "H"},
    **{"int": "i", "unsigned int": "I", "unsigned": "I", "float": "f", "double": "d", "Angle": "f"},
}
"""Primitive types as `struct` knows them."""
_UNIFYING: Final = (
    (re.compile(r"\b(?:class|struct|enum) "), ""),
    (re.compile(r"::__(?:1|cxx11)\b"), ""),
    (re.compile(r"\b(\d+)[ul]+\b"), r"\1"),
    (re.compile(r", "), ","),
    (re.compile(r" (?=[>\[])"), ""),
    (re.compile(r" *\(\*[^)]*\)"), ""),
)
_ARRAY: Final = (
    re.compile(r"(?P<of>.*)\[(?P<size>\d+)\]"),
    re.compile(r"std::array<(?P<of>.*),(?P<size>\d+)>"),
)
MAX_LOG: Final = 1 << 30
"""bytes"""
_SNAPPY_RATIO: Final = 64
"""Bytes that one of snappy unpacks to: 64 by a copy of two."""
_OFF: Final = 1000.0
"""Angles from which on a joint is off (10000) or keeps its last angle (20000), rad."""
_READ: Final = (
    "FrameInfo",
    "JointSensorData",
    "JointAngles",
    "JointRequest",
    "FsrSensorData",
    "InertialSensorData",
)
_CELLS: Final = {"fl": "FL", "fr": "FR", "bl": "RL", "br": "RR"}

Rows = dict[str, Array]


class _Types(NamedTuple):
    """The specification of a log."""

    classes: dict[str, list[tuple[str, str]]]
    """Name and type of each attribute."""
    enums: dict[str, list[str]]

    def leaves(self, kind: str, name: str = "") -> Iterator[tuple[str, str]]:
        """Path and `struct` code of each number in a value of a type.

        Raises:
            KeyError: a type without a fixed size, or one that is not specified.
        """
        kind = _unified(kind)
        if match := next(filter(None, (pattern.fullmatch(kind) for pattern in _ARRAY)), None):
            for number in range(int(match["size"])):
                yield from self.leaves(match["of"], f"{name}.{number}")
        elif kind in _CODES:
            yield name, _CODES[kind]
        elif kind in self.enums:
            yield name, "B"
        else:
            for attribute, of in self.classes[kind]:
                yield from self.leaves(of, f"{name}.{attribute}")

    def constants(self, having: str) -> Sequence[str]:
        """Names of the enumeration that has this one."""
        return next((names for names in self.enums.values() if having in names), ())


class _Stream:
    """Bytes that are read one value after the other; raises struct.error at their end."""

    def __init__(self, data: memoryview) -> None:
        self.data, self.place = data, 0

    def number(self, code: str) -> int:
        value: int = struct.unpack_from(f"<{code}", self.data, self.place)[0]
        self.place += struct.calcsize(code)
        return value

    def bytes(self, size: int) -> memoryview:
        if self.place + size > len(self.data):
            raise struct.error("the file ends within a chunk")
        self.place += size
        return self.data[self.place - size : self.place]

    def text(self) -> str:
        return str(self.bytes(self.number("I")), "utf-8", "replace")


def read_bhuman(path: Path) -> LoggedRun:
    """Read angles, requests and sensors of a log.

    Angles and requests are those of B-Human's modules, both calibrated. A request holds from the time of its
    frame.

    Raises:
        ConfigurationError: unreadable, a log without a specification of its types, or one without measurements.
    """
    stream = _Stream(memoryview(read_limited(path, MAX_LOG, f"give a B-Human log of at most {MAX_LOG} bytes")))
    try:
        ids, types, blocks = _chunks(path, stream)
        frames = _frames(path, ids, blocks)
        rows = {
            name: _decode(path, types, name, frames) for name in _READ if any(name in each for each in frames)
        }
    except struct.error as error:
        raise ConfigurationError(f"{path}: is damaged, or no B-Human log ({error}).") from None
    time, order = _times(path, rows, len(frames))
    rows = {name: {key: values[order] for key, values in each.items()} for name, each in rows.items()}
    measured, notes = _measured(types, rows)
    commands = _commands(types, rows.get("JointRequest", {}))
    if not measured:
        raise _nothing(path, ids)
    return LoggedRun(time[order], measured, time[order], commands, notes=notes)


def _chunks(path: Path, stream: _Stream) -> tuple[list[str], _Types, Iterator[memoryview]]:
    """Names of the ids, the specification, and the blocks of messages."""
    ids: list[str] = []
    types: _Types | None = None
    while True:
        kind = stream.number("B")
        if kind == _SETTINGS and not ids:
            _skip_settings(path, stream)
        elif kind == _MESSAGE_IDS and not ids:
            ids = [stream.text() for _ in range(stream.number("B"))]
        elif kind == _TYPES and ids:
            types = _specification(stream)
        elif kind in (_UNCOMPRESSED, _COMPRESSED) and types is not None:
            return ids, types, _blocks(path, stream, compressed=kind == _COMPRESSED)
        else:
            raise ConfigurationError(
                f"{path}: is no B-Human log that specifies its types; those of the releases since 2014 do (as "
                "TypeInfo, before 2017 as StreamSpecification). Export one of 2013 or earlier as CSV with the "
                "simulator of its release."
            )


def _skip_settings(path: Path, stream: _Stream) -> None:
    version = stream.number("I")
    if version != 1:
        raise ConfigurationError(f"{path}: its settings have version {version}; version 1 can be read.")
    stream.text(), stream.text(), stream.number("i"), stream.text(), stream.text()


def _specification(stream: _Stream) -> _Types:
    for _ in range(stream.number("I") & ~_UNIFIED):
        stream.text()
    classes = {}
    for _ in range(stream.number("I")):
        name = _unified(stream.text())
        classes[name] = [(stream.text(), stream.text()) for _ in range(stream.number("I"))]
    enums = {}
    for _ in range(stream.number("I")):
        name = _unified(stream.text())
        enums[name] = [stream.text() for _ in range(stream.number("I"))]
    return _Types(classes, enums)


def _unified(kind: str) -> str:
    """A type's name as newer logs write it."""
    for pattern, words in _UNIFYING:
        kind = pattern.sub(words, kind)
    return kind.strip()


def _blocks(path: Path, stream: _Stream, *, compressed: bool) -> Iterator[memoryview]:
    """Messages in a row; the index behind them in the file is left."""
    if not compressed:
        size, rest = _HEADER.unpack(stream.bytes(_HEADER.size))
        remaining = len(stream.data) - stream.place
        size |= (rest >> 28) << 32
        yield stream.bytes(remaining if rest & _OPEN == _OPEN else min(size, remaining))
        return
    try:
        import pyarrow
    except ImportError:
        raise ConfigurationError(
            f"{path}: is compressed; `pip install pyarrow` brings the decompression."
        ) from None
    while stream.place < len(stream.data):
        packed = stream.bytes(stream.number("I"))
        size = shift = 0
        for byte in packed[:5]:  # snappy begins with the size in groups of seven bits
            size |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                break
        if size > _SNAPPY_RATIO * len(packed):
            raise struct.error("a block that unpacks to more than its form allows")
        try:
            block = memoryview(pyarrow.decompress(packed, size, codec="snappy"))
        except OSError as error:
            raise struct.error(str(error)) from None
        yield block[_HEADER.size :]


def _frames(path: Path, ids: Sequence[str], blocks: Iterator[memoryview]) -> list[dict[str, memoryview]]:
    """The messages of `_READ` by their names, of each whole frame of the thread that has most of them."""
    names = {number: name[2:] for number, name in enumerate(ids) if name[2:] in _READ}
    begins = {ids.index(name) for name in ("idFrameBegin", "idProcessBegin") if name in ids}
    ends = {ids.index(name) for name in ("idFrameFinished", "idProcessFinished") if name in ids}
    frames: list[tuple[bytes, dict[str, memoryview]]] = []
    frame: dict[str, memoryview] = {}
    thread, counts = b"", Counter[bytes]()
    for block in blocks:
        place = 0
        while place + 4 <= len(block):
            head = int.from_bytes(block[place : place + 4], "little")
            number, message = head & 0xFF, block[place + 4 : place + 4 + (head >> 8)]
            place += 4 + (head >> 8)
            if place > len(block):  # cut off
                break
            if number in begins:
                thread, frame = bytes(message), {}
            elif number in names:
                frame[names[number]] = message
            elif number in ends and not frame.keys() <= {"FrameInfo", "JointRequest"}:
                frames.append((thread, frame))
                counts[thread] += 1
    if not frames:
        raise _nothing(path, ids)
    most = counts.most_common(1)[0][0]
    return [each for thread, each in frames if thread == most]


def _nothing(path: Path, ids: Sequence[str]) -> ConfigurationError:
    known = ", ".join(name[2:] for name in ids if re.search("Joint|Sensor|Fsr|Inertial", name))
    return ConfigurationError(
        f"{path}: has no frame with JointSensorData, JointAngles, InertialSensorData or FsrSensorData; its "
        f"ids of joints and sensors are {known or 'none'}."
    )


def _decode(path: Path, types: _Types, name: str, frames: Sequence[dict[str, memoryview]]) -> Rows:
    """Columns of a message by their paths, a row per frame; NaN where a frame lacks it."""
    try:
        leaves = list(types.leaves(name))
    except KeyError as error:
        raise ConfigurationError(
            f"{path}: {name} cannot be read, its type {error} has no fixed size."
        ) from None
    code = struct.Struct("<" + "".join(code for _, code in leaves))
    table = np.full((len(frames), len(leaves)), np.nan)
    for number, frame in enumerate(frames):
        if (message := frame.get(name)) is not None:
            if len(message) != code.size:
                raise ConfigurationError(
                    f"{path}: {name} has {len(message)} bytes, but {code.size} by the log's own specification."
                )
            table[number] = code.unpack(message)
    return {leaf: table[:, column] for column, (leaf, _) in enumerate(leaves)}


def _times(path: Path, rows: dict[str, Rows], count: int) -> tuple[Array, NDArray[np.int64]]:
    """Times of all frames, s, and which frames to take so that they rise."""
    clocks = [("FrameInfo", ".time"), ("JointSensorData", ".timestamp"), ("JointAngles", ".timestamp")]
    time = next((rows[name][key] for name, key in clocks if key in rows.get(name, {})), np.full(count, np.nan))
    time = 1e-3 * time
    best = np.maximum.accumulate(np.where(np.isfinite(time), time, -np.inf))
    order = np.flatnonzero(np.isfinite(time) & (time > np.append(-np.inf, best[:-1])))
    if len(order) < 2:
        raise ConfigurationError(
            f"{path}: its frames have no times; FrameInfo, or a time stamp of the joints, has them."
        )
    return time, order


def _measured(types: _Types, rows: dict[str, Rows]) -> tuple[dict[str, Array], tuple[str, ...]]:
    joints = rows.get("JointSensorData") or rows.get("JointAngles", {})
    inertial, forces = rows.get("InertialSensorData", {}), rows.get("FsrSensorData", {})
    measured: dict[str, Array] = {}
    notes: tuple[str, ...] = ()
    if joints:
        measured["position"] = _joints(types, joints, ".angles")
    for name, part, width in (("gyroscope", ".gyro", 3), ("accelerometer", ".acc", 3), ("angle", ".angle", 2)):
        columns = [values for key, values in inertial.items() if key.startswith(f"{part}.")]
        if columns:
            measured[name] = np.stack(columns[:width], axis=1)
    if "accelerometer" in measured:
        measured["accelerometer"], notes = specific_force(measured["accelerometer"], measured.get("angle"))
    if forces:
        measured["fsr"] = GRAVITY * _forces(types, forces)
    return {name: np.where(np.abs(values) < _OFF, values, np.nan) for name, values in measured.items()}, notes


def _commands(types: _Types, request: Rows) -> dict[str, Array]:
    if not request:
        return {}
    angle = _joints(types, request, ".angles")
    stiffness = _joints(types, request, ".stiffnessData.stiffnesses")
    off = np.abs(angle) >= _OFF
    # below 0: the default, which the log does not hold
    stiffness = np.where(stiffness < 0.0, np.nan, 0.01 * stiffness)
    return {"command": np.where(off, np.nan, angle), "stiffness": np.where(off, 0.0, stiffness)}


def _joints(types: _Types, rows: Rows, part: str) -> Array:
    """A value per joint, (n, 25); NaN for those that are not there."""
    constants = types.constants("headYaw")
    angles = np.full((len(next(iter(rows.values()))), len(JOINTS)), np.nan)
    for key, values in rows.items():
        if key.startswith(f"{part}."):
            name = _label(key, constants)
            slot = INDEX.get(name[:1].upper() + name[1:])
            if slot is not None:
                angles[:, slot] = values
    return angles


def _forces(types: _Types, rows: Rows) -> Array:
    """Load of each cell in kg, (n, 8); named `left.fl`, or `pressures.left.fl` in newer logs."""
    feet, cells = ("left", "right"), types.constants("fl")
    forces = np.full((len(next(iter(rows.values()))), 8), np.nan)
    for key, values in rows.items():
        parts = key.strip(".").split(".")
        foot = feet[int(parts[-2])] if parts[-2:-1] and parts[-2].isdigit() else "".join(parts[-2:-1])
        cell = _CELLS.get(_label(key, cells))
        if cell and foot in feet:
            forces[:, ELEMENTS["fsr"].index(foot[0].upper() + cell)] = values
    return forces


def _label(key: str, constants: Sequence[str]) -> str:
    """Last part of a path; of an array's element, the name of its index."""
    last = key.rpartition(".")[2]
    return constants[int(last)] if last.isdigit() and int(last) < len(constants) else last
