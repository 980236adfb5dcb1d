"""Sensors under their ALMemory names: read from a frame of the contract, and made into one.

Names: vendor's list (NAOqi 2.8, the same on V4 and V5) and the keys that B-Human reads on V3 to V5.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from bridge.datasheet import Body
from bridge.datasheet.quantities import absent_joints
from bridge.dcm.wire import PREFIX
from bridge.errors import LinkError
from bridge.joints import INDEX, JOINTS, N_JOINTS
from bridge.messages import SensorFrame
from bridge.naoqi import signs

Getter = Callable[[SensorFrame], Any]

FSR_KEYS: Final = tuple(
    f"{foot}/FSR/{cell}/Sensor/Value"
    for foot in ("LFoot", "RFoot")
    for cell in ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
)
"""In the order of `SensorFrame.fsr`."""
TOUCH_KEYS: Final = (
    "ChestBoard/Button/Sensor/Value",
    "Head/Touch/Front/Sensor/Value",
    "Head/Touch/Middle/Sensor/Value",
    "Head/Touch/Rear/Sensor/Value",
    "LFoot/Bumper/Left/Sensor/Value",
    "LFoot/Bumper/Right/Sensor/Value",
    "LHand/Touch/Back/Sensor/Value",
    "LHand/Touch/Left/Sensor/Value",
    "LHand/Touch/Right/Sensor/Value",
    "RFoot/Bumper/Left/Sensor/Value",
    "RFoot/Bumper/Right/Sensor/Value",
    "RHand/Touch/Back/Sensor/Value",
    "RHand/Touch/Left/Sensor/Value",
    "RHand/Touch/Right/Sensor/Value",
)
"""In the order of `SensorFrame.touch`."""
BATTERY_KEYS: Final = (
    "Battery/Charge/Sensor/Value",
    "Battery/Current/Sensor/Value",
    "Battery/Charge/Sensor/Status",
    "Battery/Temperature/Sensor/Value",
)
"""In the order of `SensorFrame.battery`."""
SONAR_KEYS: Final = ("US/Left/Sensor/Value", "US/Right/Sensor/Value")
ANGLE_KEYS: Final = ("InertialSensor/AngleX/Sensor/Value", "InertialSensor/AngleY/Sensor/Value")
ACCELEROMETER_KEYS: Final = tuple(f"InertialSensor/Accelerometer{axis}/Sensor/Value" for axis in "XYZ")
GYROSCOPE_KEYS: Final = tuple(f"InertialSensor/Gyroscope{axis}/Sensor/Value" for axis in "XYZ")
OLD_GYROSCOPE_KEYS: Final = ("InertialSensor/GyrX/Sensor/Value", "InertialSensor/GyrY/Sensor/Value")
"""The two axes of V3 and V4 until NAOqi 1.14; counts of 12/1600 rad/s (confirmed: B-Human 2013)."""
OLD_GYROSCOPE_STEP: Final = 12.0 / 1600.0
"""rad/s per count"""
JOINT_KEYS: Final[dict[str, str]] = {
    "position": "Position/Sensor/Value",
    "stiffness": "Hardness/Actuator/Value",
    "current": "ElectricCurrent/Sensor/Value",
    "temperature": "Temperature/Sensor/Value",
}
"""Field of the frame -> what follows the joint's name; the stiffness is what was sent last."""
HOT: Final = ((85.0, 1), (90.0, 2), (100.0, 3))
"""Degrees Celsius from which a motor's temperature status is 1, 2, 3 (as the emulated drives, assumed)."""


def getters(body: Body) -> dict[str, Getter]:
    """Name without prefix -> how to read it from a frame; absent joints and hands have none."""
    table: dict[str, Getter] = {}
    absent = set(absent_joints(body))
    for joint in (j for j in JOINTS if j not in absent):
        slot = INDEX[joint]
        for field in ("position", "current", "temperature"):
            table[f"{joint}/{JOINT_KEYS[field]}"] = _item(field, slot)
        table[f"{joint}/Temperature/Sensor/Status"] = _status(slot)
    has_hands = "LHand" not in absent
    table |= {k: _item("touch", i) for i, k in enumerate(TOUCH_KEYS) if has_hands or "Hand" not in k}
    table |= {k: _item("fsr", i, 1.0 / signs.KILOGRAM) for i, k in enumerate(FSR_KEYS)}
    table |= {k: _item("battery", i) for i, k in enumerate(BATTERY_KEYS)}
    table |= {k: _item("sonar", i) for i, k in enumerate(SONAR_KEYS)}
    # The first echo is the distance; further echoes are not emulated and read as no echo.
    table |= {k.replace("Value", f"Value{i}"): _no_echo for k in SONAR_KEYS for i in range(1, 10)}
    table["US/Sensor/Value"] = _item("sonar", 0)
    table |= {k: _item("angle", i) for i, k in enumerate(ANGLE_KEYS)}
    table["InertialSensor/AngleZ/Sensor/Value"] = _zero
    table |= {k: _signed("accelerometer", signs.accelerometer, i) for i, k in enumerate(ACCELEROMETER_KEYS)}
    axes = body.inertial_unit.gyroscope_axes
    table |= {k: _signed("gyroscope", signs.gyroscope, i) for i, k in enumerate(GYROSCOPE_KEYS[:axes])}
    if axes == 2:
        table[GYROSCOPE_KEYS[2]] = _zero
        table |= {k: _item("gyroscope", i, 1.0 / OLD_GYROSCOPE_STEP) for i, k in enumerate(OLD_GYROSCOPE_KEYS)}
        table["InertialSensor/GyrRef/Sensor/Value"] = _zero
    for side, foot in enumerate(("LFoot", "RFoot")):
        table[f"{foot}/FSR/TotalWeight/Sensor/Value"] = _weight(4 * side)
        for axis, name in enumerate("XY"):
            place = [cell[axis] for cell in (body.fsr.L, body.fsr.R)[side]]
            table[f"{foot}/FSR/CenterOfPressure/{name}/Sensor/Value"] = _centre(4 * side, place)
    table["Battery/Temperature/Sensor/Status"] = _zero
    table["Head/Temperature/Sensor/Value"] = _item("battery", 3)
    return table


def _item(field: str, index: int, factor: float = 1.0) -> Getter:
    return lambda frame: getattr(frame, field)[index] * factor


def _signed(field: str, convert: Callable[[Sequence[float]], Sequence[float]], index: int) -> Getter:
    return lambda frame: convert(getattr(frame, field))[index]


def _status(slot: int) -> Getter:
    return lambda frame: max((s for limit, s in HOT if frame.temperature[slot] >= limit), default=0)


def _weight(first: int) -> Getter:
    return lambda frame: sum(frame.fsr[first : first + 4]) / signs.KILOGRAM


def _centre(first: int, place: Sequence[float]) -> Getter:
    def centre(frame: SensorFrame) -> float:
        forces = frame.fsr[first : first + 4]
        total = sum(forces)
        return sum(f * p for f, p in zip(forces, place, strict=True)) / total if total > 0.0 else 0.0

    return centre


def _zero(_: SensorFrame) -> float:
    return 0.0


def _no_echo(_: SensorFrame) -> float:
    return 0.0


class FrameReader:
    """Makes sensor frames from a NAOqi robot's memory.

    Args:
        body: Data sheet of the robot.
        old_gyroscope: The robot names its gyroscope as NAOqi 1.14 did.
    """

    def __init__(self, body: Body, old_gyroscope: bool = False) -> None:
        absent = set(absent_joints(body))
        self._joints = [joint for joint in JOINTS if joint not in absent]
        self._old = old_gyroscope
        gyroscope = OLD_GYROSCOPE_KEYS if old_gyroscope else GYROSCOPE_KEYS[: body.inertial_unit.gyroscope_axes]
        self._axes = len(gyroscope)
        self._touch = [i for i, key in enumerate(TOUCH_KEYS) if "LHand" not in absent or "Hand" not in key]
        groups: list[Sequence[str]] = [
            ["DCM/Time"],
            *([PREFIX + f"{j}/{end}" for j in self._joints] for end in JOINT_KEYS.values()),
            *(
                [PREFIX + key for key in keys]
                for keys in (FSR_KEYS, ACCELEROMETER_KEYS, gyroscope, ANGLE_KEYS, BATTERY_KEYS, SONAR_KEYS)
            ),
            [PREFIX + TOUCH_KEYS[i] for i in self._touch],
        ]
        self._sizes = [len(group) for group in groups]
        self.keys = [key for group in groups for key in group]
        """What to ask `ALMemory.getListData` for."""

    def time(self, values: Sequence[Any]) -> int:
        """The DCM's clock among the values, ms."""
        return int(values[0])

    def fields(self, values: Sequence[Any]) -> Mapping[str, Any]:
        """Fields of a `SensorFrame` from the values of `keys`, in order; a sensor that the robot lacks reads 0.

        Raises:
            LinkError: the robot has no angle for one of the joints; names it.
        """
        for joint, value in zip(self._joints, values[1:], strict=False):
            if not isinstance(value, int | float):
                raise LinkError(
                    f"The robot's ALMemory has no angle of {joint} ({value!r:.40}); is it another body? Give "
                    "its own with --robot."
                )
        numbers = [float(value) if isinstance(value, int | float) else 0.0 for value in values]
        groups, at = [], 0
        for size in self._sizes:
            groups.append(numbers[at : at + size])
            at += size
        _, *joints, fsr, accelerometer, gyroscope, angle, battery, sonar, touch = groups
        rate = [*gyroscope, *[0.0] * (3 - self._axes)]
        if self._old:
            rate = [value * OLD_GYROSCOPE_STEP for value in rate]
        pressed = [0.0] * len(TOUCH_KEYS)
        for i, value in zip(self._touch, touch, strict=True):
            pressed[i] = value
        return dict(zip(JOINT_KEYS, map(self._by_slot, joints), strict=True)) | {
            "fsr": tuple(value * signs.KILOGRAM for value in fsr),
            "accelerometer": signs.accelerometer(accelerometer),
            "gyroscope": signs.gyroscope(rate),
            "angle": tuple(angle),
            "battery": tuple(battery),
            "sonar": tuple(sonar),
            "touch": tuple(pressed),
        }

    def _by_slot(self, values: Sequence[float]) -> tuple[float, ...]:
        slots = [0.0] * N_JOINTS
        for joint, value in zip(self._joints, values, strict=True):
            slots[INDEX[joint]] = value
        return tuple(slots)
