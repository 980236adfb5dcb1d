"""ALMemory: sensors and actuators by name, data that programs put in, and events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from bridge.adapters.naoqi.sensors import TOUCH_KEYS, getters
from bridge.body import Body
from bridge.dcm import Dcm
from bridge.dcm.actuators import short
from bridge.errors import DcmRefused, NaoqiRefused
from bridge.messages import SensorFrame
from bridge.messages.dcm import PREFIX

MAX_DATA: Final = 10_000
"""Keys that programs may put in."""
CONTACT: Final = 5.0
"""N on both soles together from which a foot touches the ground (assumed)."""
FALLEN: Final = 0.8
"""rad of torso tilt from which `robotHasFallen` is raised (about 45 deg, as the walker's own limit)."""
_EVENTS: Final = {
    "ChestBoard/Button": "ChestButtonPressed",
    "Head/Touch/Front": "FrontTactilTouched",
    "Head/Touch/Middle": "MiddleTactilTouched",
    "Head/Touch/Rear": "RearTactilTouched",
    "LHand/Touch/Back": "HandLeftBackTouched",
    "LHand/Touch/Left": "HandLeftLeftTouched",
    "LHand/Touch/Right": "HandLeftRightTouched",
    "RHand/Touch/Back": "HandRightBackTouched",
    "RHand/Touch/Left": "HandRightLeftTouched",
    "RHand/Touch/Right": "HandRightRightTouched",
}
_BUMPERS: Final = {"LFoot/Bumper": "LeftBumperPressed", "RFoot/Bumper": "RightBumperPressed"}
_BUTTONS: Final = tuple(key.removesuffix("/Sensor/Value") for key in TOUCH_KEYS)


class Memory:
    """Keys and events of one robot; not thread-safe, the caller locks.

    Args:
        body: Data sheet.
        dcm: Gives the actuators' values and the clock's; may be another one later.
        fixed: Keys that never change.
        publish: Called with name and value of each event.
    """

    def __init__(
        self,
        body: Body,
        dcm: Callable[[], Dcm],
        fixed: Mapping[str, Any],
        publish: Callable[[str, Any], None],
    ) -> None:
        self._dcm, self._publish = dcm, publish
        self._sensors = getters(body)
        buttons = [*_EVENTS.values(), *_BUMPERS.values()]
        self._data: dict[str, Any] = {**fixed, **dict.fromkeys(buttons, 0.0), "robotHasFallen": 0.0}
        self._events: set[str] = {
            "TouchChanged",
            "footContactChanged",
            "robotHasFallen",
            *_EVENTS.values(),
            *_BUMPERS.values(),
        }
        self._names = [
            *(PREFIX + name for name in self._sensors),
            *(PREFIX + actuator.name for actuator in dcm().table),
            "DCM/Time",
            "DCM/CycleTime",
            "DCM/TargetCycleTime",
        ]
        self._known = set(self._names)
        self._frame: SensorFrame | None = None
        self._fallen = False
        self._contact: bool | None = None
        """A foot touches the ground; None: before the first frame."""

    def update(self, frame: SensorFrame) -> None:
        """A new sensor frame; raises the events that it brings."""
        before, self._frame = self._frame, frame
        if before is not None and frame.touch != before.touch:
            self._touched(before.touch, frame.touch)
        fallen = max(abs(angle) for angle in frame.angle) > FALLEN
        if fallen and not self._fallen:
            self.raise_event("robotHasFallen", 1.0)
        self._fallen = fallen
        contact = sum(frame.fsr) > CONTACT
        if contact is not self._contact:
            self._data["footContact"] = float(contact)
            if self._contact is not None:
                self.raise_event("footContactChanged", contact)
        self._contact = contact

    def _touched(self, before: tuple[float, ...], now: tuple[float, ...]) -> None:
        changed = []
        for name, was, value in zip(_BUTTONS, before, now, strict=True):
            if was != value:
                changed.append([name, value > 0.5])
                event = _EVENTS.get(name) or _BUMPERS[name.rpartition("/")[0]]
                self.raise_event(event, value)
        self.raise_event("TouchChanged", changed)

    def get(self, key: Any) -> Any:
        """The value of a key, with or without the prefix.

        Raises:
            NaoqiRefused: no such key.
        """
        if not isinstance(key, str):
            raise NaoqiRefused(f"ALMemory: {key!r:.60} was given; a name is expected.")
        if key in self._data:
            return self._data[key]
        getter = self._sensors.get(short(key))
        if getter is not None and self._frame is not None:
            return getter(self._frame)
        try:
            value = self._dcm().read([key], self._frame.position if self._frame else ())[0]
        except DcmRefused:
            raise NaoqiRefused(f"ALMemory: there is no data under {key!r:.80}.") from None
        return int(value) if key == "DCM/Time" else value

    def get_list(self, keys: Any) -> list[Any]:
        """Values of several keys; None for each unknown one.

        Raises:
            NaoqiRefused: not a list of names.
        """
        if not isinstance(keys, list) or not all(isinstance(key, str) for key in keys):
            raise NaoqiRefused(f"ALMemory.getListData: {keys!r:.60} was given; a list of names is expected.")
        return [self._get_or_none(key) for key in keys]

    def _get_or_none(self, key: str) -> Any:
        try:
            return self.get(key)
        except NaoqiRefused:
            return None

    def insert(self, key: str, value: Any) -> None:
        """Put data in. On the robot, too, anyone may overwrite a sensor's key, until its next cycle.

        Raises:
            NaoqiRefused: a key of a sensor or an actuator, or too many keys.
        """
        if not isinstance(key, str):
            raise NaoqiRefused(f"ALMemory.insertData: {key!r:.60} was given; a name is expected.")
        if key in self._known or PREFIX + key in self._known:
            raise NaoqiRefused(f"ALMemory.insertData: {key!r} belongs to the robot; take another name.")
        if key not in self._data and len(self._data) >= MAX_DATA:
            raise NaoqiRefused(f"ALMemory: there are {MAX_DATA} keys already; remove some with removeData.")
        self._data[key] = value

    def insert_list(self, pairs: Any) -> None:
        """Put several in: `[[key, value], ...]`.

        Raises:
            NaoqiRefused: not such a list; nothing is put in then.
        """
        if not isinstance(pairs, list) or not all(isinstance(p, list) and len(p) == 2 for p in pairs):
            raise NaoqiRefused(
                f"ALMemory.insertListData: {pairs!r:.60} was given; [[key, value], ...] is expected."
            )
        for key, value in pairs:
            self.insert(key, value)

    def remove(self, key: Any) -> None:
        """Take data out.

        Raises:
            NaoqiRefused: there is none under this key.
        """
        if not isinstance(key, str) or key not in self._data:
            raise NaoqiRefused(f"ALMemory.removeData: there is no inserted data under {key!r:.80}.")
        del self._data[key]

    def names(self, part: Any = "") -> list[str]:
        """All keys with `part` in their name.

        Raises:
            NaoqiRefused: not a text.
        """
        if not isinstance(part, str):
            raise NaoqiRefused(f"ALMemory.getDataList: {part!r:.60} was given; a part of a name is expected.")
        return [name for name in (*self._names, *self._data) if part in name]

    def declare_event(self, name: Any, *_: Any) -> None:
        """Make an event known before it is raised.

        Raises:
            NaoqiRefused: not a name, or too many.
        """
        self._know_event("declareEvent", name)

    def events(self) -> list[str]:
        """Names of the events that were declared or raised."""
        return sorted(self._events)

    def raise_event(self, name: Any, value: Any) -> None:
        """Store the value under the event's name and tell its subscribers.

        Raises:
            NaoqiRefused: not a name, or too many.
        """
        self._know_event("raiseEvent", name)
        self._data[name] = value
        self._publish(name, value)

    def _know_event(self, method: str, name: Any) -> None:
        if not isinstance(name, str) or (len(self._events) >= MAX_DATA and name not in self._events):
            raise NaoqiRefused(f"ALMemory.{method}: {name!r:.60} cannot be an event.")
        self._events.add(name)

    def methods(self) -> dict[str, Callable[..., Any]]:
        """Methods of the service `ALMemory`; `subscriber` is in `qi_process`."""
        return {
            "getData": lambda key, *_: self.get(key),
            "getListData": self.get_list,
            "insertData": self.insert,
            "insertListData": self.insert_list,
            "removeData": self.remove,
            "getDataList": self.names,
            "getDataListName": self.names,
            "declareEvent": self.declare_event,
            "getEventList": self.events,
            "raiseEvent": self.raise_event,
            "raiseMicroEvent": self.raise_event,
            "getType": self._type,
        }

    def _type(self, key: Any) -> str:
        kinds = {bool: "Bool", int: "Int", float: "Float", str: "String"}
        return kinds.get(type(self.get(key)), "ALValue")
