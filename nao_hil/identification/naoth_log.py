"""Sensor logs of the team NaoTH (Berlin United): representations of each cycle as Protocol Buffers messages.

Source: `Framework-Representations.proto`, `JointData.h`, `FSRData.h`, `LolaDataConverter.h` of NaoTH's
repository; the Python package `naoth` reads the same files, with an old version of protobuf. A file is a
sequence of entries: number of the frame (int32), name (ended by a zero), size (int32), message.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

import numpy as np

from bridge.adapters.signs import KILOGRAM, NAOQI
from bridge.body.joints import INDEX, JOINTS
from bridge.errors import ConfigurationError
from bridge.files import open_file, read_limited
from bridge.types import Array
from nao_hil.identification.readings import COMMANDS, LoggedRun

_JOINTS: Final = (
    *("HeadPitch", "HeadYaw", "RShoulderRoll", "LShoulderRoll", "RShoulderPitch", "LShoulderPitch"),
    *("RElbowRoll", "LElbowRoll", "RElbowYaw", "LElbowYaw", "RHipYawPitch", "LHipYawPitch", "RHipPitch"),
    *("LHipPitch", "RHipRoll", "LHipRoll", "RKneePitch", "LKneePitch", "RAnklePitch", "LAnklePitch"),
    *("RAnkleRoll", "LAnkleRoll", "LWristYaw", "RWristYaw", "LHand", "RHand"),
)
"""Order of `JointID`; logs of a V3 end before the wrists."""
_MEASURED: Final = {
    "SensorJointData": ("position", (1, 1), 25),
    "AccelerometerData": ("accelerometer", (2,), 3),
    "GyrometerData": ("gyroscope", (2,), 3),
    "InertialSensorData": ("angle", (2,), 2),
    "FSRData": ("fsr", (2,), 8),
}
"""By representation: signal, its path of field numbers, width. An inner message has its numbers as fields."""
_SIGNS: Final = {"accelerometer": NAOQI.accelerometer, "gyroscope": NAOQI.gyroscope, "fsr": (KILOGRAM,)}
"""Factors to the contract's units; NaoTH turns a V6's readings into those of NAOqi."""
_RIGHT: Final = "give a sensor log of NaoTH of at most 1 GiB"
_ENTRY: Final = re.compile(rb"(?s)....[A-Za-z_]\w*\0")
_INT: Final = struct.Struct("<i")


def is_naoth(path: Path) -> bool:
    """The file begins with the number and the name of an entry."""
    with open_file(path, _RIGHT) as file:
        return _ENTRY.match(file.read(64)) is not None


def read_naoth(path: Path) -> LoggedRun:
    """Read angles, requests and sensors.

    A request holds from the time of its frame.

    Args:
        path: .log with `FrameInfo` and `SensorJointData`; `MotorJointData` has the requests.

    Raises:
        ConfigurationError: unreadable, damaged, or without these.
    """
    names: set[str] = set()
    rows: list[tuple[float, dict[str, Array]]] = []
    try:
        for frame in _frames(memoryview(read_limited(path, 1 << 30, _RIGHT))):
            names |= frame.keys()
            if {"FrameInfo", "SensorJointData"} <= frame.keys():
                time = 1e-3 * _integer(frame["FrameInfo"], 2)
                if not rows or time > rows[-1][0]:
                    rows.append((time, _signals(frame)))
    except (struct.error, ValueError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"{path}: is damaged, or no log of NaoTH ({error}).") from None
    if len(rows) < 2:
        raise ConfigurationError(
            f"{path}: has {len(rows)} frames with `FrameInfo` and `SensorJointData`, two are needed; it has "
            f"{', '.join(sorted(names)) or 'none'}."
        )
    times = np.array([each for each, _ in rows])
    widths = {name: width for name, _, width in _MEASURED.values()} | {"command": 25, "stiffness": 25}
    tables: dict[str, Array] = {
        name: np.array([row.get(name, np.full(width, np.nan)) for _, row in rows])
        for name, width in widths.items()
        if any(name in row for _, row in rows)
    }
    commands: dict[str, Array] = {name: tables.pop(name) for name in COMMANDS if name in tables}
    return LoggedRun(times, tables, times, commands)


def _frames(data: memoryview) -> Iterator[Mapping[str, memoryview]]:
    """Messages by the names of their representations, of each whole frame."""
    place, number, frame = 0, None, dict[str, memoryview]()
    while place + 4 <= len(data):
        (of,) = _INT.unpack_from(data, place)
        if of != number and frame:
            yield frame
            frame = {}
        number = of
        end = bytes(data[place + 4 : place + 132]).find(b"\0")
        if end < 0:
            raise ValueError("a name without an end")
        name, begin = str(data[place + 4 : place + 4 + end], "ascii"), place + end + 9
        if begin > len(data):
            return
        (size,) = _INT.unpack_from(data, begin - 4)
        if size < 0:
            raise ValueError("a negative size")
        place = begin + size
        if place > len(data):  # cut off
            return
        frame[name] = data[begin:place]
    yield frame


def _signals(frame: Mapping[str, memoryview]) -> dict[str, Array]:
    columns: dict[str, Array] = {}
    for representation, (name, path, width) in _MEASURED.items():
        if (message := frame.get(representation)) is not None:
            values = _numbers(message, path)
            if name == "position":
                columns[name] = _by_joint(values)
            elif len(values) >= width:
                columns[name] = np.array(values[:width]) * _SIGNS.get(name, (1.0,))
    if (message := frame.get("MotorJointData")) is not None:
        columns["command"], columns["stiffness"] = (_by_joint(_numbers(message, (field,))) for field in (1, 2))
    return columns


def _by_joint(values: list[float]) -> Array:
    """(25,), NaN for joints that are not there."""
    angles = np.full(len(JOINTS), np.nan)
    for name, value in zip(_JOINTS, values, strict=False):
        if name in INDEX:
            angles[INDEX[name]] = value
    return angles


def _fields(data: memoryview) -> Iterator[tuple[int, int, memoryview]]:
    """Number, kind and bytes of each field of a Protocol Buffers message."""
    place = 0
    while place < len(data):
        key, place = _varint(data, place)
        kind, begin = key & 7, place
        if kind == 0:
            _, place = _varint(data, place)
        elif kind == 2:
            size, begin = _varint(data, place)
            place = begin + size
        elif kind in (1, 5):
            place += 8 if kind == 1 else 4
        else:
            raise ValueError(f"a field of kind {kind}")
        if place > len(data):
            raise ValueError("a message that ends within a field")
        yield key >> 3, kind, data[begin:place]


def _varint(data: memoryview, place: int) -> tuple[int, int]:
    value = shift = 0
    while place < len(data) and shift < 64:
        byte = data[place]
        place, value, shift = place + 1, value | (byte & 0x7F) << shift, shift + 7
        if byte < 0x80:
            return value, place
    raise ValueError("a number without an end")


def _integer(data: memoryview, field: int) -> int:
    for number, kind, content in _fields(data):
        if (number, kind) == (field, 0):
            return _varint(content, 0)[0]
    raise ValueError(f"a message without field {field}")


def _numbers(data: memoryview, path: tuple[int, ...]) -> list[float]:
    """Numbers of a repeated field, packed or not, or the fields of an inner message, in their order."""
    numbers: list[float] = []
    for number, kind, content in _fields(data):
        if number != path[0]:
            continue
        if kind == 1:
            numbers += struct.unpack("<d", content)
        elif len(path) > 1:
            numbers += _numbers(content, path[1:])
        elif len(content) % 8 == 0:
            numbers += np.frombuffer(content, "<f8").tolist()
        else:
            numbers += [struct.unpack("<d", each)[0] for _, kind, each in _fields(content) if kind == 1]
    return numbers
