"""Events of ALMemory that the robot's state raises: touches, falls, the ground, postures, the battery, heat."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import wraps
from typing import Any, Final

from bridge.adapters.naoqi.events import Events
from bridge.adapters.naoqi.memory import Memory
from bridge.adapters.naoqi.postures import Postures
from bridge.adapters.naoqi.sensors import TOUCH_KEYS
from bridge.adapters.signs import KILOGRAM, motor_status
from bridge.body.joints import JOINTS
from bridge.messages import SensorFrame

CONTACT: Final = 5.0
"""N on a sole (or on both together) from which it touches the ground (assumed)."""
FALLEN: Final = 0.8
"""rad of torso tilt from which `robotHasFallen` is raised (about 45 deg, as the walker's own limit)."""
_SECOND: Final = 100
"""Cycles between two looks at what changes slowly."""
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
_FIRST: Final[dict[str, Any]] = {
    "ALMotion/RobotIsFalling": False,
    **{f"ALMotion/Stiffness/{what}": False for what in ("wakeUpStarted", "wakeUpFinished")},
    **{f"ALMotion/Stiffness/{what}": False for what in ("restStarted", "restFinished")},
    **{f"Sonar{side}{what}Detected": 0.0 for side in ("Left", "Right") for what in ("", "Nothing")},
    **{f"ALTracker/{what}": "" for what in ("TargetLost", "TargetReached", "TargetDetected")},
    "ALTracker/ActiveTargetChanged": "",
    "ALAnimatedSpeech/EndOfAnimatedSpeech": 0,
    "ALBasicAwareness/HumanTracked": -1,
    "ALBasicAwareness/HumanLost": -1,
    "ALBasicAwareness/PeopleLeft": -1,
    "ALBasicAwareness/StimulusDetected": "",
    "PeoplePerception/PeopleList": [],
}
"""Event -> its value before it is raised for the first time (assumed)."""
BATTERY_FLAGS: Final = {
    "BatteryPowerPluggedChanged": 0x8000,
    "BatteryChargingFlagChanged": 0x0080,
    "BatteryFullChargedFlagChanged": 0x0040,
    "BatteryDisChargingFlagChanged": 0x0020,
}
"""Event -> bit of the battery's status word."""


@dataclass(frozen=True)
class _Watched:
    """A value of the robot's state whose change is an event."""

    event: str
    value: Callable[[SensorFrame], Any]
    every: int = 1
    """Cycles between two looks."""
    quiet: Any = None
    """A value that is stored without an event."""


class RobotEvents:
    """Looks at each frame; not thread-safe, the caller locks.

    Args:
        events: to be raised.
        memory: gets the keys that have no event.
        postures: of the robot.
        frame: the first one.
    """

    def __init__(self, events: Events, memory: Memory, postures: Postures, frame: SensorFrame) -> None:
        self._events, self._memory, self._frame, self._count = events, memory, frame, 0
        for event in _EVENTS.values():
            events.declare(event, "ALTouch", 0.0)
        events.declare("TouchChanged", "ALTouch", [])
        self._watched = [
            _Watched("robotHasFallen", lambda f: float(max(abs(a) for a in f.angle) > FALLEN), quiet=0.0),
            _Watched("footContactChanged", lambda f: sum(f.fsr) > CONTACT),
            _Watched("robotIsWakeUp", lambda _: postures.awake),
            _Watched("ALMotion/RobotIsStand", lambda _: postures.family() == "Standing", _SECOND),
            _Watched("PostureChanged", lambda _: postures.now(), _SECOND),
            _Watched("PostureFamilyChanged", lambda _: postures.family(), _SECOND),
            _Watched("BatteryChargeChanged", lambda f: round(100.0 * f.battery[0]), _SECOND),
            _Watched("HotJointDetected", hot_joints, _SECOND),
            *(_Watched(event, _flag(bit), _SECOND) for event, bit in BATTERY_FLAGS.items()),
        ]
        self._values = {watched.event: watched.value(frame) for watched in self._watched}
        for event, value in (_FIRST | self._values).items():
            events.declare(event, "", value)
        memory.provide(
            {
                "footContact": lambda: float(sum(self._frame.fsr) > CONTACT),
                "leftFootContact": lambda: float(sum(self._frame.fsr[:4]) > CONTACT),
                "rightFootContact": lambda: float(sum(self._frame.fsr[4:]) > CONTACT),
                "leftFootTotalWeight": lambda: sum(self._frame.fsr[:4]) / KILOGRAM,
                "rightFootTotalWeight": lambda: sum(self._frame.fsr[4:]) / KILOGRAM,
            }
        )

    def told(self, name: str, method: Callable[..., Future[Any]]) -> Callable[..., Future[Any]]:
        """A method of ALMotion whose beginning and end are events: `<name>Started` and `<name>Finished`."""

        @wraps(method)
        def call(*arguments: Any) -> Future[Any]:
            done = method(*arguments)
            self._events.raise_event(f"ALMotion/Stiffness/{name}Started", True)
            finished = f"ALMotion/Stiffness/{name}Finished"
            done.add_done_callback(lambda _: self._events.raise_event(finished, True))
            return done

        return call

    def update(self, frame: SensorFrame) -> None:
        """A new sensor frame; raises the events that it brings."""
        before, self._frame = self._frame, frame
        self._count += 1
        if frame.touch != before.touch:
            self._touched(before.touch, frame.touch)
        for watched in self._watched:
            if self._count % watched.every == 0:
                self._look(watched)

    def _look(self, watched: _Watched) -> None:
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
    """`[[button, whether it is pressed], ...]` of all buttons."""
    return [[name, value > 0.5] for name, value in zip(_BUTTONS, frame.touch, strict=True)]


def hot_joints(frame: SensorFrame) -> list[str]:
    """Joints whose motors are so warm that their current is limited."""
    return [joint for joint, value in zip(JOINTS, frame.temperature, strict=True) if motor_status(value)]


def _flag(bit: int) -> Callable[[SensorFrame], bool]:
    return lambda frame: bool(int(frame.battery[2]) & bit)
