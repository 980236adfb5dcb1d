"""Sensor packets from frames of the contract and back, and command packets. Signs: `bridge.adapters.signs`.

The steps of the values are those of captured packets of V6 robots.

Confirmed on two packets of two robots: all accelerometer and gyroscope values are whole multiples of the steps,
and the 46 joint values are within 0.003 steps of theirs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Final, cast

from bridge.adapters.lola.codec import CYCLE, SENSORS, Map, pack_map
from bridge.adapters.signs import KILOGRAM, LOLA, motor_status, with_signs
from bridge.body.joints import N_JOINTS
from bridge.errors import ConfigurationError, FrameError
from bridge.messages import SensorFrame

_ID_LENGTH: Final = 20
_VERSION_LENGTH: Final = 5
POSITION_STEP: Final = 0.001534
"""rad; 2 pi / 4096 as the firmware rounds it."""
RESIDUE: Final = 4.2e-5
"""rad between each joint's values and whole steps."""
RESIDUE_SIGNS: Final = (-1, -1, -1, -1, -1, 1, -1, 1, 1, 1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, -1, 1, -1)
"""Signs of the residues of the joints that are angles, in frame order; the same on both robots."""
HAND_STEP: Final = 0.0004
"""Step of a hand's opening (assumed: all four captured values are multiples of it)."""
GYROSCOPE_STEP: Final = math.radians(500.0) / 32768.0
"""Step of a reading, rad/s."""
ACCELEROMETER_STEP: Final = 9.81 / 1024.0
"""Step of a reading, m/s^2."""
_STEPS: Final = {"Gyroscope": GYROSCOPE_STEP, "Accelerometer": ACCELEROMETER_STEP}
_HIGH_TEMPERATURE: Final = 76.0
_COOL_TEMPERATURE: Final = 70.0
_ALL_COOL: Final = (0,) * N_JOINTS
_MAX_FLOAT: Final = 3.4e38
"""Largest float 32."""


@dataclass(frozen=True, slots=True)
class Identity:
    """Ids and versions of body and head, in the order of the packet."""

    body_id: str = "P0000000A00S00I00000"
    body_version: str = "6.0.0"
    head_id: str = "P0000000A00S00F00000"
    head_version: str = "6.0.0"

    def check(self) -> Identity:
        """Itself, after a check of its lengths.

        Raises:
            ConfigurationError: a text of another length, which would move the rest of the packet.
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


def identity_of(values: Map) -> Identity:
    """The robot that sent a packet.

    Raises:
        FrameError: `RobotConfig` is missing or is not four texts.
    """
    texts = values.get("RobotConfig")
    if not isinstance(texts, list) or len(texts) != SENSORS["RobotConfig"]:
        raise FrameError("LoLA packet refused: `RobotConfig` must hold four texts.")
    return Identity(*map(str, texts))


def quantized(key: str, values: Sequence[float]) -> Sequence[float]:
    """An array of a sensor packet in the steps of a real robot."""
    if key == "Position":
        return _positions(values)
    return _whole_steps(values, _STEPS[key]) if key in _STEPS else values


def _positions(angles: Sequence[float]) -> list[float]:
    """Joint angles (rad; the last two slots are hands, 0 to 1) in the steps of a V6's encoders."""
    shifts = [sign * RESIDUE for sign in RESIDUE_SIGNS]
    joints = [
        round((a - shift) / POSITION_STEP) * POSITION_STEP + shift
        for a, shift in zip(angles, shifts, strict=False)
    ]
    return [*joints, *_whole_steps(angles[len(shifts) :], HAND_STEP)]


def _whole_steps(values: Sequence[float], step: float) -> list[float]:
    return [round(value / step) * step for value in values]


class HeatStatus:
    """`Status` of the motors: 1 from 76 degrees Celsius on, 0 again below 70; 2 and 3 are assumed."""

    def __init__(self) -> None:
        self._high = [False] * N_JOINTS

    def update(self, temperature: Sequence[float]) -> list[int]:
        """The status of each motor at these temperatures, 25, degrees Celsius."""
        rows = zip(self._high, temperature, strict=True)
        self._high = [value >= (_COOL_TEMPERATURE if high else _HIGH_TEMPERATURE) for high, value in rows]
        rows = zip(self._high, temperature, strict=True)
        return [max(int(high), level if (level := motor_status(value)) > 1 else 0) for high, value in rows]


def sensor_packet(frame: SensorFrame, identity: Identity, status: Sequence[int] = _ALL_COOL) -> bytes:
    """The 896 bytes of a V6's packet, in its steps; every key is at the same place in each packet.

    Args:
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
    """A robot's packet as a frame of the contract; its `time` is `seq` cycles, unreadable numbers are NaN.

    Args:
        values: the packet's map.
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
    """A command of all joints as a map of LoLA (276 bytes).

    Args:
        position: 25 angles, rad; hands 0 to 1.
        stiffness: 25 values, -1 to 1.
    """
    return pack_map({"Position": _clipped(position), "Stiffness": _clipped(stiffness)})


def _numbers(values: Map, key: str) -> tuple[float, ...]:
    """An array of a packet; all NaN if it is missing or has another length."""
    array = values.get(key)
    if not isinstance(array, list) or len(array) != SENSORS[key]:
        return (math.nan,) * SENSORS[key]
    return tuple(float(value) if isinstance(value, (int, float)) else math.nan for value in array)


def _clipped(values: Sequence[float]) -> list[float]:
    return [min(max(float(value), -_MAX_FLOAT), _MAX_FLOAT) for value in values]
