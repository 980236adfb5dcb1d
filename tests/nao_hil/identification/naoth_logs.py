"""Sensor logs as NaoTH writes them, from its published messages (`Framework-Representations.proto`)."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

JOINTS = (
    *("HeadPitch", "HeadYaw", "RShoulderRoll", "LShoulderRoll", "RShoulderPitch", "LShoulderPitch"),
    *("RElbowRoll", "LElbowRoll", "RElbowYaw", "LElbowYaw", "RHipYawPitch", "LHipYawPitch", "RHipPitch"),
    *("LHipPitch", "RHipRoll", "LHipRoll", "RKneePitch", "LKneePitch", "RAnklePitch", "LAnklePitch"),
    *("RAnkleRoll", "LAnkleRoll", "LWristYaw", "RWristYaw", "LHand", "RHand"),
)


def varint(value: int) -> bytes:
    groups = [value >> shift & 0x7F for shift in range(0, max(value.bit_length(), 1), 7)]
    return bytes([*(group | 0x80 for group in groups[:-1]), groups[-1]])


def inner(field: int, content: bytes) -> bytes:
    """A field that holds a message, or text."""
    return varint(field << 3 | 2) + varint(len(content)) + content


def integer(field: int, value: int) -> bytes:
    return varint(field << 3) + varint(value)


def doubles(field: int, values: Sequence[float]) -> bytes:
    """A repeated field of proto2, not packed."""
    return b"".join(varint(field << 3 | 1) + struct.pack("<d", value) for value in values)


def vector(field: int, values: Sequence[float]) -> bytes:
    """A message with a double for each axis."""
    return inner(field, b"".join(doubles(axis, [value]) for axis, value in enumerate(values, 1)))


def entry(frame: int, name: str, message: bytes) -> bytes:
    return struct.pack("<i", frame) + name.encode() + b"\0" + struct.pack("<i", len(message)) + message


def frame(
    number: int,
    time: int,
    angles: Sequence[float],
    requests: Sequence[float],
    *,
    accelerometer: Sequence[float] = (0.0, 0.0, -9.81),
    gyroscope: Sequence[float] = (0.0, 0.0, 0.0),
    angle: Sequence[float] = (0.0, 0.0),
    fsr: Sequence[float] = (0.0,) * 8,
) -> bytes:
    """All representations of one cycle; time in ms, forces in kg, angles in the order of `JOINTS`."""
    n = len(angles)
    joints = doubles(1, angles) + doubles(2, [1.0] * n) + doubles(3, [0.0] * n) + doubles(4, [0.0] * n)
    sensed = inner(1, joints) + doubles(2, [38.0] * n) + doubles(3, [0.1] * n)
    asked = doubles(1, requests) + doubles(2, [0.8] * n) + doubles(3, [0.0] * n) + doubles(4, [0.0] * n)
    return b"".join(
        entry(number, name, message)
        for name, message in (
            ("FrameInfo", integer(1, number) + integer(2, time)),
            ("SensorJointData", sensed),
            ("MotorJointData", asked),
            ("AccelerometerData", vector(2, accelerometer) + vector(3, accelerometer)),
            ("GyrometerData", vector(2, gyroscope) + vector(3, gyroscope) + doubles(4, [0.0])),
            ("InertialSensorData", vector(2, angle)),
            ("FSRData", doubles(2, fsr)),
        )
    )


def write_log(path: Path, frames: Sequence[bytes]) -> Path:
    path.write_bytes(b"".join(frames))
    return path
