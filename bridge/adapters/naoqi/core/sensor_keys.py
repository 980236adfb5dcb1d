"""Sensors under their ALMemory names, read from a frame of the contract.

Names: vendor's list (NAOqi 2.8, the same on V4 and V5) and the keys that B-Human reads on V3 to V5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

from bridge.adapters.signs import KILOGRAM, NAOQI, motor_status, with_signs
from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS
from bridge.body.quantities import absent_joints
from bridge.messages import SensorFrame
from bridge.types import Vec3

Getter = Callable[[SensorFrame], Any]

FSR_KEYS: Final = tuple(
    f"{foot}/FSR/{cell}/Sensor/Value"
    for foot in ("LFoot", "RFoot")
    for cell in ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
)
"""In the order of `SensorFrame.fsr`."""
TOUCH_EVENTS: Final = {
    "ChestBoard/Button": "ChestButtonPressed",
    **{f"Head/Touch/{part}": f"{part}TactilTouched" for part in ("Front", "Middle", "Rear")},
    **{f"LFoot/Bumper/{side}": "LeftBumperPressed" for side in ("Left", "Right")},
    **{f"LHand/Touch/{part}": f"HandLeft{part}Touched" for part in ("Back", "Left", "Right")},
    **{f"RFoot/Bumper/{side}": "RightBumperPressed" for side in ("Left", "Right")},
    **{f"RHand/Touch/{part}": f"HandRight{part}Touched" for part in ("Back", "Left", "Right")},
}
"""Button -> its event; both bumpers of a foot have the same."""
TOUCH_KEYS: Final = tuple(f"{button}/Sensor/Value" for button in TOUCH_EVENTS)
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
"""The two axes of V3 and V4 until NAOqi 1.14; counts of 12/1600 rad/s (confirmed: B-Human 2013). Samples for
NAOqi 2.1 read them too (the unit there is assumed to be the same)."""
_OLD_ACCELEROMETER_KEYS: Final = tuple(f"InertialSensor/Acc{axis}/Sensor/Value" for axis in "XYZ")
"""The same samples; m/s^2 (assumed)."""
OLD_GYROSCOPE_STEP: Final = 12.0 / 1600.0
"""rad/s per count"""
JOINT_KEYS: Final[dict[str, str]] = {
    "position": "Position/Sensor/Value",
    "stiffness": "Hardness/Actuator/Value",
    "current": "ElectricCurrent/Sensor/Value",
    "temperature": "Temperature/Sensor/Value",
}
"""Field of the frame -> suffix of the joint's key; the stiffness is the last command."""


def getters(body: Body) -> dict[str, Getter]:
    """Name without prefix -> getter of its value from a frame; absent joints and hands have none."""
    table: dict[str, Getter] = {}
    absent = set(absent_joints(body))
    for joint in (j for j in JOINTS if j not in absent):
        slot = INDEX[joint]
        for field in ("position", "current", "temperature"):
            table[f"{joint}/{JOINT_KEYS[field]}"] = _item(field, slot)
        table[f"{joint}/Temperature/Sensor/Status"] = _status(slot)
    for field in ("position", "current", "temperature"):  # one motor drives both hips
        table[f"RHipYawPitch/{JOINT_KEYS[field]}"] = table[f"LHipYawPitch/{JOINT_KEYS[field]}"]
    table["RHipYawPitch/Temperature/Sensor/Status"] = table["LHipYawPitch/Temperature/Sensor/Status"]
    has_hands = "LHand" not in absent
    table |= {k: _item("touch", i) for i, k in enumerate(TOUCH_KEYS) if has_hands or "Hand" not in k}
    table |= {k: _item("fsr", i, 1.0 / KILOGRAM) for i, k in enumerate(FSR_KEYS)}
    table |= {k: _item("battery", i) for i, k in enumerate(BATTERY_KEYS)}
    table |= {k: _item("sonar", i) for i, k in enumerate(SONAR_KEYS)}
    # The first echo is the distance; further echoes are not emulated and read as no echo.
    table |= {k.replace("Value", f"Value{i}"): _zero for k in SONAR_KEYS for i in range(1, 10)}
    table["US/Sensor/Value"] = _item("sonar", 0)
    table |= {k: _item("angle", i) for i, k in enumerate(ANGLE_KEYS)}
    table["InertialSensor/AngleZ/Sensor/Value"] = _zero
    for keys in (ACCELEROMETER_KEYS, _OLD_ACCELEROMETER_KEYS):
        table |= {k: _signed("accelerometer", NAOQI.accelerometer, i) for i, k in enumerate(keys)}
    axes = body.inertial_unit.gyroscope_axes
    table |= {k: _signed("gyroscope", NAOQI.gyroscope, i) for i, k in enumerate(GYROSCOPE_KEYS[:axes])}
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


def _signed(field: str, signs: Vec3, index: int) -> Getter:
    return lambda frame: with_signs(getattr(frame, field), signs)[index]


def _status(slot: int) -> Getter:
    return lambda frame: motor_status(frame.temperature[slot])


def _weight(first: int) -> Getter:
    return lambda frame: sum(frame.fsr[first : first + 4]) / KILOGRAM


def _centre(first: int, place: Sequence[float]) -> Getter:
    def centre(frame: SensorFrame) -> float:
        forces = frame.fsr[first : first + 4]
        total = sum(forces)
        return sum(f * p for f, p in zip(forces, place, strict=True)) / total if total > 0.0 else 0.0

    return centre


def _zero(_: SensorFrame) -> float:
    return 0.0
