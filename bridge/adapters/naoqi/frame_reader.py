"""Sensor frames from the memory of a NAOqi robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bridge.adapters.naoqi.sensors import (
    ACCELEROMETER_KEYS,
    ANGLE_KEYS,
    BATTERY_KEYS,
    FSR_KEYS,
    GYROSCOPE_KEYS,
    JOINT_KEYS,
    OLD_GYROSCOPE_KEYS,
    OLD_GYROSCOPE_STEP,
    SONAR_KEYS,
    TOUCH_KEYS,
)
from bridge.adapters.signs import KILOGRAM, NAOQI, with_signs
from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS, N_JOINTS
from bridge.body.quantities import absent_joints
from bridge.errors import LinkError
from bridge.messages.dcm import PREFIX


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
            "fsr": tuple(value * KILOGRAM for value in fsr),
            "accelerometer": with_signs(accelerometer, NAOQI.accelerometer),
            "gyroscope": with_signs(rate, NAOQI.gyroscope),
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
