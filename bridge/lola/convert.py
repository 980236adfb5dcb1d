"""Between the contract's frames and LoLA's maps: signs, units, orders.

| | contract | LoLA |
|---|---|---|
| accelerometer | specific force: upright z is +9.81 m/s^2 | gravity: upright z is -9.81 m/s^2 |
| force sensors | N | kg |
| battery | charge, current, status, temperature | charge, status, current, temperature |
| joint states | not in the frame | by motor temperature |

Everything else is the same on both sides. Sources: the vendor's page on LoLA; the battery's order as captured
packets have it (the page differs); the accelerometer's sign held against the angles of two captured packets.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Final, cast

from bridge.errors import ConfigurationError, FrameError
from bridge.joints import N_JOINTS
from bridge.lola.grid import on_grid
from bridge.lola.schema import CYCLE, SENSORS
from bridge.lola.wire import Map, pack_map
from bridge.messages import SensorFrame

GRAVITY: Final = 9.81
"""m/s^2; what turns the sensors' kg into N."""
STATUS_FROM: Final = (85.0, 90.0, 100.0)
"""Degrees Celsius from which a motor's status is 1 (limit reached), 2 (very hot), 3 (critical); assumed."""
_LARGEST: Final = 3.4e38
"""A float 32 holds no more."""
_ID_LENGTH, _VERSION_LENGTH = 20, 5


@dataclass(frozen=True, slots=True)
class Identity:
    """Who a packet says the robot is (`RobotConfig`)."""

    body_id: str = "P0000000A00S00I00000"
    body_version: str = "6.0.0"
    head_id: str = "P0000000A00S00F00000"
    head_version: str = "6.0.0"

    def check(self) -> Identity:
        """Itself, if it fits into a packet.

        Raises:
            ConfigurationError: a text of another length would move everything behind it in the packet.
        """
        for name, text, length in (
            ("Body id", self.body_id, _ID_LENGTH),
            ("Body version", self.body_version, _VERSION_LENGTH),
            ("Head id", self.head_id, _ID_LENGTH),
            ("Head version", self.head_version, _VERSION_LENGTH),
        ):
            if len(text) != length or not text.isascii() or not text.isprintable():
                raise ConfigurationError(f"{name} {text!r} must have {length} printable ASCII characters.")
        return self


def sensor_packet(frame: SensorFrame, identity: Identity) -> bytes:
    """A frame as the 896 bytes that a V6 would send, in a V6's steps; every key at the same place each time."""
    values = lola_values(frame)
    on = {key: [_fit(v) for v in on_grid(key, array)] for key, array in values.items()}
    return pack_map({"RobotConfig": astuple(identity), **on, "Status": _status(frame.temperature)})


def lola_values(frame: SensorFrame) -> dict[str, Sequence[float]]:
    """The numbers of a frame under LoLA's keys and conventions, in the order of the wire; not yet rounded."""
    charge, current, status, temperature = frame.battery
    return {
        "Accelerometer": [0.0 - a for a in frame.accelerometer],
        "Angles": frame.angle,
        "Battery": (charge, status, current, temperature),
        "Current": frame.current,
        "FSR": [force / GRAVITY for force in frame.fsr],
        "Gyroscope": frame.gyroscope,
        "Position": frame.position,
        "Sonar": frame.sonar,
        "Stiffness": frame.stiffness,
        "Temperature": frame.temperature,
        "Touch": frame.touch,
    }


def sensor_frame(values: Map, *, seq: int, command: int = -1, missed: int = 0) -> SensorFrame:
    """A robot's packet as a frame of the contract; its `time` is `seq` cycles.

    Args:
        values: the packet's map.
        seq: number of the packet since the connection began.
        command: `reply_to` of the actuator frame sent last before the packet came.
        missed: cycles without an answer so far.

    Raises:
        FrameError: a key is missing, or its array has another length or holds what is no finite number.
    """
    n = {key: _numbers(values, key) for key in SENSORS if key not in ("RobotConfig", "Status")}
    charge, status, current, temperature = n["Battery"]
    x, y, z = n["Accelerometer"]
    return SensorFrame(
        seq=seq,
        time=seq * CYCLE,
        position=n["Position"],
        stiffness=n["Stiffness"],
        current=n["Current"],
        temperature=n["Temperature"],
        fsr=tuple(mass * GRAVITY for mass in n["FSR"]),
        accelerometer=(0.0 - x, 0.0 - y, 0.0 - z),
        gyroscope=cast("tuple[float, float, float]", n["Gyroscope"]),
        angle=cast("tuple[float, float]", n["Angles"]),
        touch=n["Touch"],
        battery=(charge, current, status, temperature),
        sonar=cast("tuple[float, float]", n["Sonar"]),
        command=command,
        missed=missed,
    )


def identity_of(values: Map) -> Identity:
    """Who the packet says the robot is.

    Raises:
        FrameError: `RobotConfig` is missing or is not four texts.
    """
    texts = values.get("RobotConfig")
    if not isinstance(texts, list) or len(texts) != SENSORS["RobotConfig"]:
        raise FrameError("LoLA packet refused: `RobotConfig` must hold four texts.")
    return Identity(*map(str, texts))


def actuator_map(position: Sequence[float], stiffness: Sequence[float]) -> bytes:
    """A command of all joints as a client of LoLA writes it (276 bytes)."""
    return pack_map({"Position": [_fit(v) for v in position], "Stiffness": [_fit(v) for v in stiffness]})


def _numbers(values: Map, key: str) -> tuple[float, ...]:
    array = values.get(key)
    length = SENSORS[key]
    if not isinstance(array, list) or len(array) != length:
        found = f"{len(array)} elements" if isinstance(array, list) else "nothing of the kind"
        raise FrameError(f"LoLA packet refused: `{key}` must be an array of {length} numbers, and is {found}.")
    if not all(isinstance(v, (int, float)) and math.isfinite(v) for v in array):
        raise FrameError(f"LoLA packet refused: `{key}` holds something that is no finite number.")
    return tuple(float(cast("float", v)) for v in array)


def _status(temperature: Sequence[float]) -> list[int]:
    assert len(temperature) == N_JOINTS
    return [sum(t >= limit for limit in STATUS_FROM) for t in temperature]


def _fit(value: float) -> float:
    return min(max(float(value), -_LARGEST), _LARGEST)
