"""Services of sensors, and events of the robot's state.

Touches, falls, ground contact, postures, battery and heat raise events; ALSonar, ALTouch, ALSensors, ALBattery
and ALBodyTemperature answer calls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final

from bridge.adapters.naoqi.core.joints import CONTACT_FORCE, Joints
from bridge.adapters.naoqi.core.postures import Postures
from bridge.adapters.naoqi.core.sensor_keys import SONAR_KEYS, TOUCH_EVENTS, TOUCH_KEYS
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import VENDOR_METHODS, Range, number, offers
from bridge.adapters.signs import KILOGRAM, motor_status
from bridge.body.fall import has_fallen, tilt
from bridge.body.joints import JOINTS
from bridge.body.quantities import absent_joints
from bridge.errors import NaoqiRefused
from bridge.messages import SensorFrame
from bridge.messages.dcm import PREFIX

_SLOW_CYCLES: Final = 100
"""Cycles between two checks of slow quantities."""
BATTERY_FLAGS: Final = {
    "BatteryPowerPluggedChanged": 0x8000,
    "BatteryChargingFlagChanged": 0x0080,
    "BatteryFullChargedFlagChanged": 0x0040,
    "BatteryDisChargingFlagChanged": 0x0020,
}
"""Event -> bit of the battery's status word."""


@dataclass(frozen=True)
class _Watched:
    """A value of the robot's state with an event for its changes."""

    event: str
    value: Callable[[SensorFrame], Any]
    every: int = 1
    """Cycles between two checks."""
    quiet: Any = None
    """A value stored without an event."""


class RobotEvents(Service):
    """Raises the events of changes between frames."""

    def __init__(self, robot: ServedRobot, postures: Postures) -> None:
        super().__init__(robot)
        frame = self._frame = self._joints.frame
        self._postures, self._count = postures, 0
        events = self._events
        self._watched = [
            _Watched("robotHasFallen", lambda f: float(has_fallen(tilt(f.angle))), quiet=0.0),
            _Watched("footContactChanged", lambda f: sum(f.fsr) > CONTACT_FORCE),
            _Watched("robotIsWakeUp", lambda _: postures.awake),
            _Watched("ALMotion/RobotIsStand", lambda _: postures.family() == "Standing", _SLOW_CYCLES),
            _Watched("PostureChanged", lambda _: postures.now(), _SLOW_CYCLES),
            _Watched("PostureFamilyChanged", lambda _: postures.family(), _SLOW_CYCLES),
            _Watched("BatteryChargeChanged", lambda f: round(100.0 * f.battery[0]), _SLOW_CYCLES),
            _Watched("HotJointDetected", hot_joints, _SLOW_CYCLES),
            *(
                _Watched(event, lambda f, bit=bit: bool(int(f.battery[2]) & bit), _SLOW_CYCLES)  # type: ignore[misc]
                for event, bit in BATTERY_FLAGS.items()
            ),
        ]
        self._values = {watched.event: watched.value(frame) for watched in self._watched}
        for event, value in self._values.items():
            events.declare(event, "", value)
        self._memory.provide(
            {
                "footContact": lambda: float(sum(self._frame.fsr) > CONTACT_FORCE),
                "leftFootContact": lambda: float(sum(self._frame.fsr[:4]) > CONTACT_FORCE),
                "rightFootContact": lambda: float(sum(self._frame.fsr[4:]) > CONTACT_FORCE),
                "leftFootTotalWeight": lambda: sum(self._frame.fsr[:4]) / KILOGRAM,
                "rightFootTotalWeight": lambda: sum(self._frame.fsr[4:]) / KILOGRAM,
            }
        )

    def update(self, frame: SensorFrame) -> None:
        """Take a new sensor frame and raise its events."""
        before, self._frame = self._frame, frame
        self._count += 1
        if frame.touch != before.touch:
            self._touched(before.touch, frame.touch)
        for watched in self._watched:
            if self._count % watched.every == 0:
                self._check(watched)

    def _check(self, watched: _Watched) -> None:
        value = watched.value(self._frame)
        if value == self._values[watched.event]:
            return
        self._values[watched.event] = value
        if value == watched.quiet:
            self._memory.put(watched.event, value)
        else:
            self._events.raise_event(watched.event, value)

    def _touched(self, before: tuple[float, ...], now: tuple[float, ...]) -> None:
        changed = []
        for name, was, value in zip(TOUCH_EVENTS, before, now, strict=True):
            if was != value:
                changed.append([name, value > 0.5])
                self._events.raise_event(TOUCH_EVENTS[name], value)
        self._events.raise_event("TouchChanged", changed)


def hot_joints(frame: SensorFrame) -> list[str]:
    """Joints whose hot motors have a limited current."""
    return [joint for joint, value in zip(JOINTS, frame.temperature, strict=True) if motor_status(value)]


MAX_SUBSCRIBERS = 1000
_MAX_PERIOD = 3_600_000
"""Longest period of a subscription, ms."""


DEFAULT_PERIOD: Final = 100
"""ms between two results (assumed)."""
Period = Annotated[int, Range(0, _MAX_PERIOD, "ms")]


class Extractor(Service):
    """Subscriptions of one service."""

    keys: Sequence[str] = ()
    """Further keys of ALMemory that it writes."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._subscribers: dict[str, tuple[int, float]] = {}
        """Name -> period (ms) and precision."""

    @property
    def raised(self) -> Sequence[str]:
        """Its events."""
        known = VENDOR_METHODS.get(self.service)
        return tuple(known.events) if known else ()

    @property
    def running(self) -> bool:
        """Whether the service or one of its events has a subscriber."""
        return bool(self._subscribers) or any(map(self._events.listened, self.raised))

    @property
    def period(self) -> int:
        """Between two results, ms: the subscribers' shortest."""
        return min((period for period, _ in self._subscribers.values()), default=DEFAULT_PERIOD)

    @offers(".subscribe")
    def subscribe(
        self, name: str, period: Period | None = None, precision: Annotated[float, Range(0.0, 1.0)] = 1.0
    ) -> None:
        """Start the service for a subscriber.

        Args:
            period: between two results, ms.
            precision: 0 to 1; without effect.
        """
        milliseconds = DEFAULT_PERIOD if period is None else period
        if name in self._subscribers or len(self._subscribers) < MAX_SUBSCRIBERS:
            self._subscribers[name] = (milliseconds, precision)

    @offers(".unsubscribe")
    def unsubscribe(self, name: str) -> None:
        """End a subscription, if there is one; the last one stops the service."""
        self._subscribers.pop(name, None)

    @offers(".updatePeriod")
    def _set_period(self, name: str, period: Period) -> None:
        milliseconds = period
        if name in self._subscribers:
            self._subscribers[name] = (milliseconds, self._subscribers[name][1])

    @offers(".updatePrecision")
    def _set_precision(self, name: str, precision: Annotated[float, Range(0.0, 1.0)]) -> None:
        if name in self._subscribers:
            self._subscribers[name] = (self._subscribers[name][0], precision)

    @offers(".getMyPeriod", which=0)
    @offers(".getMyPrecision", which=1)
    def _get_my(self, name: str, *, which: int) -> Any:
        return self._subscribers.get(name, (0, 0.0))[which]

    _get_current_period = offers(".getCurrentPeriod")(lambda self: self.period)
    _get_current_precision = offers(".getCurrentPrecision")(
        lambda self: max((fine for _, fine in self._subscribers.values()), default=1.0)
    )
    _get_subscribers_info = offers(".getSubscribersInfo")(
        lambda self: [[name, *values] for name, values in self._subscribers.items()]
    )
    _get_output_names = offers(".getOutputNames")(lambda self: [*self.raised, *self.keys])
    _get_event_list = offers(".getEventList")(lambda self: list(self.raised))
    _get_memory_key_list = offers(".getMemoryKeyList")(lambda self: list(self.keys))


class VisionExtractor(Extractor):
    """An extractor with a camera; not thread-safe, the caller locks."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self.camera = 0
        """0 top, 1 bottom."""
        self._paused = False
        self._settings: dict[str, Any] = {"FrameRate": 5, "Resolution": 1}
        """Settings without effect here, with their initial values (assumed)."""

    @property
    def processing(self) -> bool:
        """Whether it runs without a pause."""
        return self.running and not self._paused

    @offers(".setActiveCamera")
    def _set_camera(self, camera: Annotated[float, Range(0, 1)]) -> bool:
        self.camera = round(camera)
        return True

    @offers(".pause")
    def _pause(self, paused: bool) -> None:
        self._paused = paused

    @offers(".setFrameRate", name="FrameRate", most=30)
    @offers(".setResolution", name="Resolution", most=8)
    def _store(self, *values: Any, name: str, most: float) -> bool:
        """Store a value, the only argument or the one after a subscriber's name."""
        method = f"{self.service}.set{name}"
        if len(values) not in (1, 2):
            raise NaoqiRefused(f"{method} takes a value, or a name and a value.")
        self._settings[name] = round(number(values[-1], method, 0, most))
        return True

    _get_active_camera = offers(".getActiveCamera")(lambda self: self.camera)
    _is_paused = offers(".isPaused")(lambda self: self._paused)
    _is_processing = offers(".isProcessing")(lambda self: self.processing)
    _get_frame_rate = offers(".getFrameRate")(lambda self: self._settings["FrameRate"])
    _get_resolution = offers(".getResolution")(lambda self: self._settings["Resolution"])


QUIET_SERVICES: Final[dict[str, type[Extractor]]] = {
    **dict.fromkeys(("ALPeoplePerception", "ALSoundDetection", "ALSoundLocalization"), Extractor),
    **dict.fromkeys(("ALBarcodeReader", "ALDarknessDetection"), VisionExtractor),
    **dict.fromkeys(("ALMovementDetection", "ALVisionRecognition"), VisionExtractor),
}
"""Services that perceive nothing; their events hold empty lists."""


def quiet_services(robot: ServedRobot) -> list[Extractor]:
    """The services that perceive nothing."""
    return [type(name, (kind,), {"service": name})(robot) for name, kind in QUIET_SERVICES.items()]


SONAR_NEAR: Final = 0.5
"""Range of the sonar's detection, m (confirmed: vendor's page)."""
_SIDES: Final = ("Left", "Right")


class Sonar(Extractor):
    """`ALSonar` and its events."""

    service = "ALSonar"
    keys = tuple(PREFIX + key for key in SONAR_KEYS)
    _near: tuple[bool | None, ...] = (None, None)

    def update(self) -> None:
        """One cycle."""
        if not self.running:
            self._near = (None, None)
            return
        near = tuple(distance <= SONAR_NEAR for distance in self._joints.frame.sonar)
        before, self._near = self._near, near
        for side, distance, is_near, was in zip(_SIDES, self._joints.frame.sonar, near, before, strict=True):
            if is_near is not was:
                self._events.raise_event(f"Sonar{side}{'' if is_near else 'Nothing'}Detected", distance)

    _get_filtered_values = offers("ALSonar.getFilteredValues")(lambda self: list(self._joints.frame.sonar))


BUTTON_KEYS: Final = [PREFIX + key for key in TOUCH_KEYS]


class Sensors(Extractor):
    """`ALSensors`."""

    service, keys = "ALSensors", BUTTON_KEYS


class Touch(Extractor):
    """`ALTouch`."""

    service, raised, keys = "ALTouch", ("TouchChanged",), BUTTON_KEYS

    _get_status = offers("ALTouch.getStatus")(
        lambda self: [
            [name, value > 0.5] for name, value in zip(TOUCH_EVENTS, self._joints.frame.touch, strict=True)
        ]
    )
    _get_sensor_list = offers("ALTouch.getSensorList")(lambda self: list(TOUCH_EVENTS))


class BatteryAndHeat(Service):
    """`ALBattery` and `ALBodyTemperature`."""

    _notifies = True

    _get_battery_charge = offers("ALBattery.getBatteryCharge")(
        lambda self: round(100.0 * self._joints.frame.battery[0])
    )
    _get_temperature_diagnosis = offers("ALBodyTemperature.getTemperatureDiagnosis")(
        lambda self: _diagnosis(self._joints)
    )
    _are_notifications_enabled = offers("ALBodyTemperature.areNotificationsEnabled")(
        lambda self: self._notifies
    )

    @offers("ALBodyTemperature.setEnableNotifications")
    def _notify(self, enabled: bool) -> None:
        self._notifies = enabled


def _diagnosis(joints: Joints) -> list[Any]:
    """`[level, [joint, ...]]`: 1 or 2 and the joints of that heat; empty: none."""
    absent = absent_joints(joints.body)
    statuses = {
        joint: motor_status(value)
        for joint, value in zip(JOINTS, joints.frame.temperature, strict=True)
        if joint not in absent
    }
    level = min(2, max(statuses.values()))
    return [level, [joint for joint, status in statuses.items() if status >= level]] if level else []
