"""Services of sensors, and events of the robot's state.

Touches, falls, ground contact, postures, battery and heat raise events; ALSonar, ALTouch, ALSensors, ALBattery
and ALBodyTemperature answer calls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Annotated, Any, Final

from bridge.adapters.naoqi.core.joints import Joints
from bridge.adapters.naoqi.core.memory import Events, Memory
from bridge.adapters.naoqi.core.postures import Postures
from bridge.adapters.naoqi.core.sensor_keys import SONAR_KEYS, TOUCH_KEYS
from bridge.adapters.naoqi.declared import INERT, Range, number, offers
from bridge.adapters.signs import KILOGRAM, motor_status
from bridge.body.fall import has_fallen, tilt
from bridge.body.joints import JOINTS
from bridge.body.quantities import absent_joints
from bridge.errors import NaoqiRefused
from bridge.messages import SensorFrame
from bridge.messages.dcm import PREFIX

CONTACT_FORCE: Final = 5.0
"""Force on a sole (or on both together) from which it touches the ground, N (assumed)."""
_SLOW_CYCLES: Final = 100
"""Cycles between two checks of slow quantities."""
_BUTTONS: Final = tuple(key.removesuffix("/Sensor/Value") for key in TOUCH_KEYS)
_EVENTS: Final = {
    "ChestBoard/Button": "ChestButtonPressed",
    "Head/Touch/Front": "FrontTactilTouched",
    "Head/Touch/Middle": "MiddleTactilTouched",
    "Head/Touch/Rear": "RearTactilTouched",
    "LFoot/Bumper/Left": "LeftBumperPressed",
    "LFoot/Bumper/Right": "LeftBumperPressed",
    "RFoot/Bumper/Left": "RightBumperPressed",
    "RFoot/Bumper/Right": "RightBumperPressed",
    "LHand/Touch/Back": "HandLeftBackTouched",
    "LHand/Touch/Left": "HandLeftLeftTouched",
    "LHand/Touch/Right": "HandLeftRightTouched",
    "RHand/Touch/Back": "HandRightBackTouched",
    "RHand/Touch/Left": "HandRightLeftTouched",
    "RHand/Touch/Right": "HandRightRightTouched",
}
"""Button -> its event; both bumpers of a foot have the same."""
_INITIAL_VALUES: Final[dict[str, Any]] = {
    "ALMotion/RobotIsFalling": False,
    **{f"ALMotion/Stiffness/{event}": False for event in ("wakeUpStarted", "wakeUpFinished")},
    **{f"ALMotion/Stiffness/{event}": False for event in ("restStarted", "restFinished")},
    **{f"Sonar{side}{event}Detected": 0.0 for side in ("Left", "Right") for event in ("", "Nothing")},
    **{f"ALTracker/{event}": "" for event in ("TargetLost", "TargetReached", "TargetDetected")},
    "ALTracker/ActiveTargetChanged": "",
    "ALAnimatedSpeech/EndOfAnimatedSpeech": 0,
    "ALBasicAwareness/HumanTracked": -1,
    "ALBasicAwareness/HumanLost": -1,
    "ALBasicAwareness/PeopleLeft": -1,
    "ALBasicAwareness/StimulusDetected": "",
    "PeoplePerception/PeopleList": [],
}
"""Event -> its initial value (assumed)."""
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


class RobotEvents:
    """Raises the events of changes between frames; not thread-safe, the caller locks.

    Args:
        events: to be raised.
        memory: for the keys without an event.
        postures: of the robot.
        frame: the first one.
    """

    def __init__(self, events: Events, memory: Memory, postures: Postures, frame: SensorFrame) -> None:
        self._events, self._memory, self._frame, self._count = events, memory, frame, 0
        self._postures = postures
        for event in _EVENTS.values():
            events.declare(event, "ALTouch", 0.0)
        events.declare("TouchChanged", "ALTouch", [])
        self._watched = [
            _Watched("robotHasFallen", lambda f: float(has_fallen(tilt(f.angle))), quiet=0.0),
            _Watched("footContactChanged", lambda f: sum(f.fsr) > CONTACT_FORCE),
            _Watched("robotIsWakeUp", lambda _: postures.awake),
            _Watched("ALMotion/RobotIsStand", lambda _: postures.family() == "Standing", _SLOW_CYCLES),
            _Watched("PostureChanged", lambda _: postures.now(), _SLOW_CYCLES),
            _Watched("PostureFamilyChanged", lambda _: postures.family(), _SLOW_CYCLES),
            _Watched("BatteryChargeChanged", lambda f: round(100.0 * f.battery[0]), _SLOW_CYCLES),
            _Watched("HotJointDetected", hot_joints, _SLOW_CYCLES),
            *(_Watched(event, _flag(bit), _SLOW_CYCLES) for event, bit in BATTERY_FLAGS.items()),
        ]
        self._values = {watched.event: watched.value(frame) for watched in self._watched}
        for event, value in (_INITIAL_VALUES | self._values).items():
            events.declare(event, "", value)
        memory.provide(
            {
                "footContact": lambda: float(sum(self._frame.fsr) > CONTACT_FORCE),
                "leftFootContact": lambda: float(sum(self._frame.fsr[:4]) > CONTACT_FORCE),
                "rightFootContact": lambda: float(sum(self._frame.fsr[4:]) > CONTACT_FORCE),
                "leftFootTotalWeight": lambda: sum(self._frame.fsr[:4]) / KILOGRAM,
                "rightFootTotalWeight": lambda: sum(self._frame.fsr[4:]) / KILOGRAM,
            }
        )

    @offers("ALMotion.wakeUp", kind="posture")
    def wake_up(self) -> Future[Any]:
        """Switch the stiffness on, and stand up from a crouch."""
        return self._announced("wakeUp", self._postures.wake_up())

    @offers("ALMotion.rest", kind="posture", partly="the legs keep a stiffness of 0.1")
    def rest(self, part: Any = "Body") -> Future[Any]:
        """Crouch, if the robot is upright, and switch the stiffness off."""
        return self._announced("rest", self._postures.rest(part))

    def _announced(self, name: str, done: Future[Any]) -> Future[Any]:
        """Raise events of the beginning and the end: `<name>Started` and `<name>Finished`."""
        self._events.raise_event(f"ALMotion/Stiffness/{name}Started", True)
        finished = f"ALMotion/Stiffness/{name}Finished"
        done.add_done_callback(lambda _: self._events.raise_event(finished, True))
        return done

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
        for name, was, value in zip(_BUTTONS, before, now, strict=True):
            if was != value:
                changed.append([name, value > 0.5])
                self._events.raise_event(_EVENTS[name], value)
        self._events.raise_event("TouchChanged", changed)


def touch_status(frame: SensorFrame) -> list[list[Any]]:
    """`[[button, is pressed], ...]` of all buttons."""
    return [[name, value > 0.5] for name, value in zip(_BUTTONS, frame.touch, strict=True)]


def hot_joints(frame: SensorFrame) -> list[str]:
    """Joints whose hot motors have a limited current."""
    return [joint for joint, value in zip(JOINTS, frame.temperature, strict=True) if motor_status(value)]


def _flag(bit: int) -> Callable[[SensorFrame], bool]:
    return lambda frame: bool(int(frame.battery[2]) & bit)


QUIET_SERVICES: Final = {
    "ALPeoplePerception": "PeoplePerception/PeopleDetected",
    "ALSoundDetection": "SoundDetected",
    "ALSoundLocalization": "ALSoundLocalization/SoundLocated",
}
"""Service that perceives nothing, without people and sound -> its event."""
QUIET_VISION: Final = {
    "ALBarcodeReader": "BarcodeReader/BarcodeDetected",
    "ALDarknessDetection": "DarknessDetection/DarknessDetected",
    "ALMovementDetection": "MovementDetection/MovementDetected",
    "ALVisionRecognition": "PictureDetected",
}
"""As `QUIET_SERVICES`, of services with a camera."""
MAX_SUBSCRIBERS = 1000
_MAX_PERIOD = 3_600_000
"""Longest period of a subscription, ms."""


Period = Annotated[int, Range(0, _MAX_PERIOD, "ms")]


class Extractor:
    """Subscriptions of one service; not thread-safe, the caller locks.

    Args:
        service: its name.
        events: for the declaration of its events.
        raised: names of its events.
        keys: further keys that it writes.
        period: default between two results, ms.
        quiet: it perceives nothing, and its events hold empty lists.
        left_out: omission of `subscribe`.
    """

    def __init__(
        self,
        service: str,
        events: Events,
        raised: Sequence[str],
        keys: Sequence[str] = (),
        period: int = 100,
        *,
        quiet: bool = False,
        left_out: str = "",
    ) -> None:
        self.service, self._events = service, events
        self._raised, self._keys, self._period = tuple(raised), tuple(keys), period
        self.left_out = {"subscribe": left_out or ("nothing is perceived" if quiet else "")}
        self._subscribers: dict[str, tuple[int, float]] = {}
        """Name -> period (ms) and precision."""
        for event in raised:
            events.declare(event, service, [] if quiet else None)

    @property
    def running(self) -> bool:
        """Whether the service or one of its events has a subscriber."""
        return bool(self._subscribers) or any(map(self._events.listened, self._raised))

    @property
    def period(self) -> int:
        """Between two results, ms: the subscribers' shortest."""
        return min((period for period, _ in self._subscribers.values()), default=self._period)

    @offers(".subscribe")
    def subscribe(
        self, name: str, period: Period | None = None, precision: Annotated[float, Range(0.0, 1.0)] = 1.0
    ) -> None:
        """Start the service for a subscriber.

        Args:
            name: of the subscriber.
            period: between two results, ms.
            precision: 0 to 1; without effect.
        """
        milliseconds = self._period if period is None else period
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

    @offers(".getMyPeriod")
    def _get_my_period(self, name: str) -> Any:
        return self._subscribers.get(name, (0, 0.0))[0]

    @offers(".getMyPrecision")
    def _get_my_precision(self, name: str) -> Any:
        return self._subscribers.get(name, (0, 0.0))[1]

    _get_current_period = offers(".getCurrentPeriod")(lambda self: self.period)
    _get_current_precision = offers(".getCurrentPrecision")(
        lambda self: max((fine for _, fine in self._subscribers.values()), default=1.0)
    )
    _get_subscribers_info = offers(".getSubscribersInfo")(
        lambda self: [[name, *values] for name, values in self._subscribers.items()]
    )
    _get_output_names = offers(".getOutputNames")(lambda self: [*self._raised, *self._keys])
    _get_event_list = offers(".getEventList")(lambda self: list(self._raised))
    _get_memory_key_list = offers(".getMemoryKeyList")(lambda self: list(self._keys))


class VisionExtractor(Extractor):
    """An extractor with a camera; not thread-safe, the caller locks."""

    def __init__(
        self,
        service: str,
        events: Events,
        raised: Sequence[str],
        period: int = 100,
        *,
        quiet: bool = False,
        left_out: str = "",
    ) -> None:
        super().__init__(service, events, raised, period=period, quiet=quiet, left_out=left_out)
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

    def _store(self, name: str, values: Sequence[Any], most: float) -> bool:
        """Store a value, the only argument or the one after a subscriber's name."""
        method = f"{self.service}.set{name}"
        if len(values) not in (1, 2):
            raise NaoqiRefused(f"{method} takes a value, or a name and a value.")
        self._settings[name] = round(number(values[-1], method, 0, most))
        return True

    @offers(".setFrameRate", partly=INERT)
    def _set_frame_rate(self, *values: Any) -> Any:
        return self._store("FrameRate", values, 30)

    @offers(".setResolution", partly=INERT)
    def _set_resolution(self, *values: Any) -> Any:
        return self._store("Resolution", values, 8)

    @offers(".setParameter", partly="without effect")
    def _set_parameter(self, name: str, value: Any) -> Any:
        return name and None

    _get_active_camera = offers(".getActiveCamera")(lambda self: self.camera)
    _is_paused = offers(".isPaused")(lambda self: self._paused)
    _is_processing = offers(".isProcessing")(lambda self: self.processing)
    _get_frame_rate = offers(".getFrameRate")(lambda self: self._settings["FrameRate"])
    _get_resolution = offers(".getResolution")(lambda self: self._settings["Resolution"])


SONAR_NEAR: Final = 0.5
"""Range of the sonar's detection, m (confirmed: vendor's page)."""
_SIDES: Final = ("Left", "Right")


class Sonar:
    """`ALSonar` and its events; not thread-safe, the caller locks.

    Args:
        joints: of the robot; their frames have the distances.
        events: to be raised.
    """

    def __init__(self, joints: Joints, events: Events) -> None:
        self._joints, self._events = joints, events
        raised = [f"Sonar{side}{event}" for side in _SIDES for event in ("Detected", "NothingDetected")]
        keys = [PREFIX + key for key in SONAR_KEYS]
        self.extractor = Extractor(
            "ALSonar", events, raised, keys, left_out="period and precision are without effect"
        )
        self._near: list[bool | None] = [None, None]

    def update(self) -> None:
        """One cycle."""
        if not self.extractor.running:
            self._near = [None, None]
            return
        for i, (side, distance) in enumerate(zip(_SIDES, self._joints.frame.sonar, strict=True)):
            near = distance <= SONAR_NEAR
            if near is not self._near[i]:
                self._near[i] = near
                self._events.raise_event(f"Sonar{side}{'' if near else 'Nothing'}Detected", distance)

    _get_filtered_values = offers("ALSonar.getFilteredValues")(lambda self: list(self._joints.frame.sonar))


class Touch(Extractor):
    """`ALTouch`.

    Args:
        joints: of the robot; its newest frame has the sensors.
        events: of ALMemory.
    """

    def __init__(self, joints: Joints, events: Events) -> None:
        super().__init__("ALTouch", events, ["TouchChanged"], BUTTON_KEYS)
        self._joints = joints

    _get_status = offers("ALTouch.getStatus")(lambda self: touch_status(self._joints.frame))
    _get_sensor_list = offers("ALTouch.getSensorList")(
        lambda self: [name for name, _ in touch_status(self._joints.frame)]
    )


BUTTON_KEYS: Final = [PREFIX + key for key in TOUCH_KEYS]


class BatteryAndHeat:
    """`ALBattery` and `ALBodyTemperature`.

    Args:
        joints: of the robot; its newest frame has the sensors.
    """

    def __init__(self, joints: Joints) -> None:
        self._joints, self._notifies = joints, True

    _get_battery_charge = offers("ALBattery.getBatteryCharge")(
        lambda self: round(100.0 * self._joints.frame.battery[0])
    )
    _get_temperature_diagnosis = offers("ALBodyTemperature.getTemperatureDiagnosis")(
        lambda self: _diagnosis(self._joints)
    )
    _are_notifications_enabled = offers("ALBodyTemperature.areNotificationsEnabled")(
        lambda self: self._notifies
    )

    @offers("ALBattery.enablePowerMonitoring", partly=INERT)
    def _monitor(self, enabled: bool) -> None:
        """Without effect."""

    @offers("ALBodyTemperature.setEnableNotifications", partly=INERT)
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
