"""Sensor packets from frames of the contract and back, and command packets. Signs: `bridge.adapters.signs`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple
from typing import Final, cast

from bridge.adapters.lola.codec import Map, pack_map
from bridge.adapters.lola.identity import Identity
from bridge.adapters.lola.quantization import quantized
from bridge.adapters.lola.schema import CYCLE, SENSORS
from bridge.adapters.signs import KILOGRAM, LOLA, motor_status, with_signs
from bridge.body.joints import N_JOINTS
from bridge.errors import FrameError
from bridge.messages import SensorFrame

_HIGH: Final = 76.0
_COOL: Final = 70.0
_COLD: Final = (0,) * N_JOINTS
_MAX_FLOAT: Final = 3.4e38
"""A float 32 holds no more."""


class HeatStatus:
    """`Status` of the motors: 1 from 76 degrees Celsius on, 0 again below 70; 2 and 3 are assumed."""

    def __init__(self) -> None:
        self._high = [False] * N_JOINTS

    def update(self, temperature: Sequence[float]) -> list[int]:
        """The status of each motor at these temperatures, 25, degrees Celsius."""
        rows = zip(self._high, temperature, strict=True)
        self._high = [value >= (_COOL if high else _HIGH) for high, value in rows]
        rows = zip(self._high, temperature, strict=True)
        return [max(int(high), level if (level := motor_status(value)) > 1 else 0) for high, value in rows]


def sensor_packet(frame: SensorFrame, identity: Identity, status: Sequence[int] = _COLD) -> bytes:
    """The 896 bytes that a V6 would send, in a V6's steps; every key is at the same place in each packet.

    Args:
        frame: sensor values.
        identity: of the robot that the packet names.
        status: of the motors, 25, see `HeatStatus`.
    """
    values = {key: _clipped(quantized(key, array)) for key, array in lola_values(frame).items()}
    return pack_map({"RobotConfig": astuple(identity), **values, "Status": list(status)})


def lola_values(frame: SensorFrame) -> dict[str, Sequence[float]]:
    """The numbers of a frame under LoLA's keys and conventions, in the order of the wire; not yet rounded."""
    charge, current, status, temperature = frame.battery
    return {
        "Accelerometer": with_signs(frame.accelerometer, LOLA.accelerometer),
        "Angles": frame.angle,
        "Battery": (charge, status, current, temperature),
        "Current": frame.current,
        "FSR": [force / KILOGRAM for force in frame.fsr],
        "Gyroscope": with_signs(frame.gyroscope, LOLA.gyroscope),
        "Position": frame.position,
        "Sonar": frame.sonar,
        "Stiffness": frame.stiffness,
        "Temperature": frame.temperature,
        "Touch": frame.touch,
    }


def sensor_frame(values: Map, *, seq: int) -> SensorFrame:
    """A robot's packet as a frame of the contract; its `time` is `seq` cycles.

    Args:
        values: the packet's map.
        seq: number of the packet since the connection began.

    Raises:
        FrameError: a key is missing, or its array has another length or holds what is no finite number.
    """
    n = {key: _numbers(values, key) for key in SENSORS if key not in ("RobotConfig", "Status")}
    charge, status, current, temperature = n["Battery"]
    return SensorFrame(
        seq=seq,
        time=seq * CYCLE,
        position=n["Position"],
        stiffness=n["Stiffness"],
        current=n["Current"],
        temperature=n["Temperature"],
        fsr=tuple(mass * KILOGRAM for mass in n["FSR"]),
        accelerometer=with_signs(n["Accelerometer"], LOLA.accelerometer),
        gyroscope=with_signs(n["Gyroscope"], LOLA.gyroscope),
        angle=cast("tuple[float, float]", n["Angles"]),
        touch=n["Touch"],
        battery=(charge, current, status, temperature),
        sonar=cast("tuple[float, float]", n["Sonar"]),
    )


def actuator_map(position: Sequence[float], stiffness: Sequence[float]) -> bytes:
    """A command of all joints as a client of LoLA writes it (276 bytes).

    Args:
        position: 25 angles, rad; hands 0 to 1.
        stiffness: 25 values, -1 to 1.
    """
    return pack_map({"Position": _clipped(position), "Stiffness": _clipped(stiffness)})


def _numbers(values: Map, key: str) -> tuple[float, ...]:
    array = values.get(key)
    length = SENSORS[key]
    if not isinstance(array, list) or len(array) != length:
        found = f"{len(array)} elements" if isinstance(array, list) else "nothing of the kind"
        raise FrameError(f"LoLA packet refused: `{key}` must be an array of {length} numbers, and is {found}.")
    if not all(isinstance(v, (int, float)) and math.isfinite(v) for v in array):
        raise FrameError(f"LoLA packet refused: `{key}` holds something that is no finite number.")
    return tuple(float(cast("float", v)) for v in array)


def _clipped(values: Sequence[float]) -> list[float]:
    return [min(max(float(value), -_MAX_FLOAT), _MAX_FLOAT) for value in values]
