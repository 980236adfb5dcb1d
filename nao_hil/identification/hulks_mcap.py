"""MCAP files of the team HULKs: outputs of their control cycle, each message a value in MessagePack.

Source: `McapConverter`, `SensorData`, `MotorCommands`, `Joints` of the HULKs' repository.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import msgpack
import numpy as np
from mcap.records import Channel, Message

from bridge.body.joints import INDEX, JOINTS
from bridge.body.quantities import GRAVITY
from bridge.errors import ConfigurationError
from bridge.recording.playback import mcap_records
from bridge.types import Array
from nao_hil.identification.readings import LoggedRun, specific_force

ENCODING: Final = "messagepack"
"""`message_encoding` of the channels, in lower case."""
_SENSORS: Final = "sensor_data"
_COMMANDS: Final = ("actuated_motor_commands", "optimized_motor_commands", "motor_commands")
"""Outputs that hold requests, in the frame of the calibrated angles; the first that is there is read."""
_FOOT: Final = ("front_left", "front_right", "rear_left", "rear_right")


def is_hulks(path: Path) -> bool:
    """The file's first channels hold MessagePack.

    Raises:
        ConfigurationError: no MCAP file, or a damaged one.
    """
    for record in mcap_records(path):
        if isinstance(record, Message):
            return False
        if isinstance(record, Channel) and record.message_encoding.lower() == ENCODING:
            return True
    return False


def read_hulks(path: Path) -> LoggedRun:
    """Read angles, requests and sensors.

    Args:
        path: .mcap with the output `sensor_data`; requests are those of `_COMMANDS`.

    Raises:
        ConfigurationError: damaged, no `sensor_data`, or messages without names of their fields.
    """
    messages: dict[str, list[tuple[float, Any]]] = {name: [] for name in (_SENSORS, *_COMMANDS)}
    topics = set()
    try:
        for topic, when, data in _messages(path):
            topics.add(topic)
            name = topic.rpartition(".")[2]
            if name in messages and (value := msgpack.unpackb(data)) is not None:
                messages[name].append((when, value))
    except (ValueError, msgpack.UnpackException) as error:
        raise ConfigurationError(
            f"{path}: is damaged ({error}); recover the readable part with `mcap recover` of the MCAP project."
        ) from None
    if len(messages[_SENSORS]) < 2:
        raise ConfigurationError(
            f"{path}: has no topic `Control.main_outputs.{_SENSORS}`; its topics are "
            f"{', '.join(sorted(topics)) or 'none'}."
        )
    try:
        time, sensors = _rising(messages[_SENSORS])
        measured, notes = _measured(sensors)
        asked = next((messages[name] for name in _COMMANDS if messages[name]), [])
        command_time, commands = _rising(asked)
        requests = {
            name: np.array([_joints(value[part]) for value in commands])
            for name, part in (("command", "positions"), ("stiffness", "stiffnesses"))
            if commands
        }
    except (TypeError, KeyError, IndexError, AttributeError) as error:
        raise ConfigurationError(
            f"{path}: a message lacks a field's name ({error}); the HULKs' MCAP converter writes `positions`, "
            "`inertial_measurement_unit`, `stiffnesses` and such with names, older ones without cannot be read."
        ) from None
    apart = bool(commands) and (command_time[0] > time[-1] or command_time[-1] < time[0])
    return LoggedRun(time, measured, command_time, requests, apart, notes)


def _messages(path: Path) -> list[tuple[str, float, bytes]]:
    """Topic, time (s) and content, by time."""
    topics: dict[int, str] = {}
    messages = []
    for record in mcap_records(path):
        if isinstance(record, Channel) and record.message_encoding.lower() == ENCODING:
            topics[record.id] = record.topic
        elif isinstance(record, Message) and record.channel_id in topics:
            messages.append((topics[record.channel_id], 1e-9 * record.log_time, record.data))
    return sorted(messages, key=lambda message: message[1])


def _rising(messages: list[tuple[float, Any]]) -> tuple[Array, list[Any]]:
    """Times and values, those left out whose time is not after all before."""
    kept: list[tuple[float, Any]] = []
    for time, value in messages:
        if not kept or time > kept[-1][0]:
            kept.append((time, value))
    return np.array([time for time, _ in kept]), [value for _, value in kept]


def _measured(sensors: list[Any]) -> tuple[dict[str, Array], tuple[str, ...]]:
    units = [value["inertial_measurement_unit"] for value in sensors]
    feet = [value["force_sensitive_resistors"] for value in sensors]
    angle = np.array([_vector(unit["roll_pitch"])[:2] for unit in units])
    acceleration = np.array([_vector(unit["linear_acceleration"]) for unit in units])
    acceleration, notes = specific_force(acceleration, angle)
    return {
        "position": np.array([_joints(value["positions"]) for value in sensors]),
        "accelerometer": acceleration,
        "gyroscope": np.array([_vector(unit["angular_velocity"]) for unit in units]),
        "angle": angle,
        "fsr": GRAVITY
        * np.array([[foot[side][cell] for side in ("left", "right") for cell in _FOOT] for foot in feet]),
    }, notes


def _joints(value: dict[str, dict[str, float]]) -> list[float]:
    """A value per joint, in frame order: `left_arm`, `shoulder_pitch` is LShoulderPitch."""
    angles = [float("nan")] * len(JOINTS)
    for limb, joints in value.items():
        side = "Head" if limb == "head" else limb[0].upper()
        for joint, number in joints.items():
            slot = INDEX.get(side + "".join(part.capitalize() for part in joint.split("_")))
            if slot is not None:
                angles[slot] = number
    return angles


def _vector(value: Any) -> list[float]:
    """Components, which a frame's wrapper may hold under a name of its own."""
    while isinstance(value, dict) and len(value) == 1:
        value = next(iter(value.values()))
    return list(value.values() if isinstance(value, dict) else value)
