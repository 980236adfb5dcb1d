"""ALSonar, ALTouch, ALSensors, ALBattery and ALBodyTemperature: what the sensors of a frame say."""

from __future__ import annotations

from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag
from bridge.adapters.naoqi.events import Events
from bridge.adapters.naoqi.extractor import Extractor
from bridge.adapters.naoqi.joints import Joints
from bridge.adapters.naoqi.methods import Method, Table, of_kind
from bridge.adapters.naoqi.robot_events import touch_status
from bridge.adapters.naoqi.sensors import SONAR_KEYS, TOUCH_KEYS
from bridge.adapters.signs import motor_status
from bridge.body.joints import JOINTS
from bridge.body.quantities import absent_joints
from bridge.messages.dcm import PREFIX

NEAR: Final = 0.5
"""m within which the sonar detects something (confirmed: vendor's page)."""
_SIDES: Final = ("Left", "Right")


class Sonar:
    """`ALSonar`: raises its events while it runs; not thread-safe, the caller locks.

    Args:
        joints: whose frames have the distances.
        events: to be raised.
    """

    def __init__(self, joints: Joints, events: Events) -> None:
        self._joints, self._events = joints, events
        raised = [f"Sonar{side}{what}" for side in _SIDES for what in ("Detected", "NothingDetected")]
        self._extractor = Extractor("ALSonar", events, raised, [PREFIX + key for key in SONAR_KEYS])
        self._near: list[bool | None] = [None, None]

    def update(self) -> None:
        """One cycle."""
        if not self._extractor.running:
            self._near = [None, None]
            return
        for i, (side, distance) in enumerate(zip(_SIDES, self._joints.frame.sonar, strict=True)):
            near = distance <= NEAR
            if near is not self._near[i]:
                self._near[i] = near
                self._events.raise_event(f"Sonar{side}{'' if near else 'Nothing'}Detected", distance)

    def methods(self) -> Table:
        """Methods of the service."""
        return self._extractor.methods() | {"getFilteredValues": lambda: list(self._joints.frame.sonar)}


def sensing_services(joints: Joints, events: Events, sonar: Sonar) -> dict[str, dict[str, Method]]:
    """Service -> methods.

    Args:
        joints: of the robot; its newest frame has the sensors.
        events: of ALMemory.
        sonar: of the robot.
    """
    notifies = [True]

    def put_notifies(enabled: Any) -> None:
        notifies[0] = flag(enabled, "ALBodyTemperature.setEnableNotifications: enabled")

    buttons = [PREFIX + key for key in TOUCH_KEYS]
    tables: dict[str, Table] = {
        "ALSonar": sonar.methods(),
        "ALTouch": Extractor("ALTouch", events, ["TouchChanged"], buttons).methods()
        | {
            "getStatus": lambda: touch_status(joints.frame),
            "getSensorList": lambda: [name for name, _ in touch_status(joints.frame)],
        },
        "ALSensors": Extractor("ALSensors", events, [], buttons).methods(),
        "ALBattery": {
            "getBatteryCharge": lambda: round(100.0 * joints.frame.battery[0]),
            "enablePowerMonitoring": lambda enabled: flag(enabled, "ALBattery.enablePowerMonitoring") and None,
        },
        "ALBodyTemperature": {
            "getTemperatureDiagnosis": lambda: _diagnosis(joints),
            "setEnableNotifications": put_notifies,
            "areNotificationsEnabled": lambda: notifies[0],
        },
    }
    return {name: of_kind("read", table) for name, table in tables.items()}


def _diagnosis(joints: Joints) -> list[Any]:
    """`[level, [joint, ...]]`: 1 or 2 and the joints that are that warm; empty when none is."""
    absent = absent_joints(joints.body)
    statuses = {
        joint: motor_status(value)
        for joint, value in zip(JOINTS, joints.frame.temperature, strict=True)
        if joint not in absent
    }
    level = min(2, max(statuses.values()))
    return [level, [joint for joint, status in statuses.items() if status >= level]] if level else []
