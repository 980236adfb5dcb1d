"""ALMemory: sensors and actuators by name, data of programs, and events with their subscribers."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.core.sensor_keys import getters
from bridge.adapters.naoqi.declared import Pairs, offers, text
from bridge.body import Body
from bridge.dcm import Dcm
from bridge.dcm.actuators import short
from bridge.errors import DcmRefused, NaoqiRefused
from bridge.messages import SensorFrame
from bridge.messages.dcm import PREFIX

MAX_DATA: Final = 10_000
"""Largest number of programs' keys."""


class Memory:
    """Data of one robot; not thread-safe, the caller locks."""

    def __init__(self, body: Body, dcm: Callable[[], Dcm], fixed: Mapping[str, Any]) -> None:
        self._dcm = dcm
        self._sensors = getters(body)
        self._data: dict[str, Any] = dict(fixed)
        self._live: dict[str, Callable[[], Any]] = {}
        self._stamps: dict[str, float] = {}
        self._descriptions: dict[str, str] = {}
        self._waiting: dict[str, list[Future[Any]]] = {}
        """Calls that wait for the next value of a key."""
        self._names = [
            *(PREFIX + name for name in self._sensors),
            *(PREFIX + actuator.name for actuator in dcm().table),
            "DCM/Time",
            "DCM/CycleTime",
            "DCM/TargetCycleTime",
        ]
        self._known = set(self._names)
        self._frame: SensorFrame | None = None

    def update(self, frame: SensorFrame) -> None:
        """A new sensor frame."""
        self._frame = frame

    def provide(self, values: Mapping[str, Callable[[], Any]]) -> None:
        """Add keys with values computed at each reading."""
        self._live.update(values)

    def put(self, key: str, value: Any) -> None:
        """Store a value under a key of the robot's own, and answer the calls that wait for it."""
        self._data[key] = value
        self._stamps[key] = time.time()
        for waiting in self._waiting.pop(key, []):
            waiting.set_result(value)

    def get(self, key: Any) -> Any:
        """The value of a key, with or without the prefix."""
        name = text(key, "ALMemory: key")
        if name in self._live:
            return self._live[name]()
        if name in self._data:
            return self._data[name]
        getter = self._sensors.get(short(name))
        if getter is not None and self._frame is not None:
            return getter(self._frame)
        actuator = name.replace("RHipYawPitch", "LHipYawPitch")  # one motor drives both hips
        try:
            value = self._dcm().read([actuator], self._frame.position if self._frame else ())[0]
        except DcmRefused:
            raise NaoqiRefused(f"ALMemory: there is no data under {name!r:.80}.") from None
        return int(value) if name == "DCM/Time" else value

    @offers("ALMemory.getListData")
    def get_list(self, keys: Any) -> list[Any]:
        """Values of several keys; None for each unknown one."""
        values = []
        for key in _names(keys, "getListData"):
            try:
                values.append(self.get(key))
            except NaoqiRefused:
                values.append(None)
        return values

    @offers("ALMemory.insertData")
    def insert(self, key: str, value: Any) -> None:
        """Store data."""
        if key in self._known or PREFIX + key in self._known or key in self._live:
            raise NaoqiRefused(f"ALMemory.insertData: {key!r:.80} belongs to the robot; take another key.")
        if key not in self._data and len(self._data) >= MAX_DATA:
            raise NaoqiRefused(f"ALMemory: there are {MAX_DATA} keys already; remove some with removeData.")
        self.put(key, value)

    @offers("ALMemory.insertListData")
    def insert_list(self, pairs: Pairs) -> None:
        """Store several: `[[key, value], ...]`."""
        for key, value in pairs:
            self.insert(key, value)

    @offers("ALMemory.removeData")
    def remove(self, key: Any) -> None:
        """Remove data."""
        if not isinstance(key, str) or key not in self._data:
            raise NaoqiRefused(f"ALMemory.removeData: there is no inserted data under {key!r:.80}.")
        del self._data[key]

    @offers("ALMemory.getDataList", "ALMemory.getDataListName")
    def names(self, part: str = "") -> list[str]:
        """All keys with `part` in their name."""
        return [name for name in (*self._names, *self._live, *self._data) if part in name]

    @offers("ALMemory.getTimestamp")
    def stamped(self, key: Any) -> list[Any]:
        """`[value, s, us]`: a value and the wall-clock time of its writing; for a sensor the present one."""
        value = self.get(key)
        return [value, *stamp(self._stamps.get(key))]

    @offers("ALMemory.getDataOnChange")
    def next_value(self, key: str, _deprecated: Any = 0) -> Future[Any]:
        """The next value written under a key; waits for it."""
        done: Future[Any] = Future()
        if sum(map(len, self._waiting.values())) >= MAX_DATA:
            raise NaoqiRefused(f"ALMemory.getDataOnChange: {MAX_DATA} calls wait already.")
        self._waiting.setdefault(key, []).append(done)
        return done

    @offers("ALMemory.setDescription")
    def describe(self, key: str, description: str) -> None:
        """Keep a description of a key."""
        if len(self._descriptions) < MAX_DATA:
            self._descriptions[key] = description

    @offers("ALMemory.getDescriptionList")
    def descriptions(self, keys: Any) -> list[list[str]]:
        """`[[key, description], ...]` of the described ones."""
        wanted = _names(keys, "getDescriptionList")
        return [[key, self._descriptions[key]] for key in wanted if key in self._descriptions]

    @offers("ALMemory.getType")
    def _type(self, key: Any) -> str:
        kinds = {bool: "Bool", int: "Int", float: "Float", str: "String"}
        return kinds.get(type(self.get(key)), "ALValue")

    @offers("ALMemory.getData")
    def _get_data(self, key: Any, *_: Any) -> Any:
        return self.get(key)


def stamp(moment: float | None = None) -> list[int]:
    """`[s, us]` of a wall-clock time, s; None: of now."""
    seconds, part = divmod(time.time() if moment is None else moment, 1.0)
    return [int(seconds), int(1e6 * part)]


def _names(keys: Any, method: str) -> list[str]:
    if not isinstance(keys, list) or not all(isinstance(key, str) for key in keys):
        raise NaoqiRefused(f"ALMemory.{method}: {keys!r:.60} was given; a list of names is expected.")
    if len(keys) > MAX_DATA:
        raise NaoqiRefused(f"ALMemory.{method}: {len(keys)} names were given; {MAX_DATA} at most are taken.")
    return keys


MAX_HISTORY: Final = 10
"""Kept values of an event (assumed)."""
Publish = Callable[[str, Any, list[list[Any]]], None]
"""Publishes an event: its name, its value, and `[module, method, message]` of each module to be called.

A list in place of the message is the method's argument list.
"""


class Events:
    """Events of one robot; not thread-safe, the caller locks.

    Args:
        publish: called for each raised event.
        has_signal: event -> whether a client has its signal (`ALMemory.subscriber`).
    """

    def __init__(self, memory: Memory, publish: Publish, has_signal: Callable[[str], bool]) -> None:
        self._memory, self._publish, self._has_signal = memory, publish, has_signal
        self._declared: dict[str, str] = {}
        """Event -> the extractor that raises it, or an empty name."""
        self._micro: set[str] = set()
        self._subscriptions: dict[str, dict[str, list[str]]] = {}
        """Event -> module -> `[module, method, message]`."""
        self._history: dict[str, deque[list[Any]]] = {}

    def declare(self, name: Any, extractor: Any = "", value: Any = None) -> None:
        """Declare an event, with an initial value, if any."""
        self._declare_new("declareEvent", name)
        self._declared[name] = text(extractor, "ALMemory.declareEvent: extractor")
        if value is not None:
            self._memory.put(name, value)

    @offers("ALMemory.raiseEvent")
    @offers("ALMemory.raiseMicroEvent", micro=True)
    def raise_event(self, name: Any, value: Any, *, micro: bool = False) -> None:
        """Store the value under the event's name and publish it to the subscribers."""
        self._declare_new("raiseEvent", name)
        self._micro |= {name} if micro else set()
        self._memory.put(name, value)
        past = self._history.setdefault(name, deque(maxlen=MAX_HISTORY))
        past.append([value, stamp()])
        self._publish(name, value, [list(one) for one in self._subscriptions.get(name, {}).values()])

    def _declare_new(self, method: str, name: Any) -> None:
        if not isinstance(name, str) or (len(self._declared) >= MAX_DATA and name not in self._declared):
            raise NaoqiRefused(f"ALMemory.{method}: {name!r:.60} cannot be an event.")
        self._declared.setdefault(name, "")

    @offers("ALMemory.subscribeToEvent", "ALMemory.subscribeToMicroEvent")
    def subscribe(self, name: str, module: str, *rest: Any) -> None:
        """Have a module's method called as `method(event, value, message)`.

        Args:
            module: a service of this session, usually a program's; `qi_server` checks it and the method.
        """
        if len(rest) not in (1, 2):
            raise NaoqiRefused(
                "ALMemory.subscribeToEvent takes (event, module, method) or (event, module, message, method)."
            )
        *message, method = (text(part, "ALMemory.subscribeToEvent: method") for part in rest)
        self._declare_new("subscribeToEvent", name)
        self._subscriptions.setdefault(name, {})[module] = [module, method, message[0] if message else ""]

    @offers("ALMemory.unsubscribeToEvent", "ALMemory.unsubscribeToMicroEvent")
    def unsubscribe(self, name: str, module: str) -> None:
        """End a module's subscription, if there is one."""
        self._subscriptions.get(name, {}).pop(module, None)

    @offers("ALMemory.unregisterModuleReference")
    def forget_module(self, module: str) -> None:
        """End all of a module's subscriptions."""
        for subscriptions in self._subscriptions.values():
            subscriptions.pop(module, None)

    @offers("ALMemory.getSubscribers")
    def subscribers(self, name: str) -> list[str]:
        """Modules with a subscription to an event."""
        return sorted(self._subscriptions.get(name, {}))

    def listened(self, name: str) -> bool:
        """Whether a module or a signal waits for an event, which then starts its extractor."""
        return bool(self._subscriptions.get(name)) or self._has_signal(name)

    @offers("ALMemory.removeEvent", "ALMemory.removeMicroEvent")
    def forget(self, name: str) -> None:
        """Remove an event and its subscriptions."""
        self._declared.pop(name, None)
        self._subscriptions.pop(name, None)
        self._history.pop(name, None)
        self._micro.discard(name)

    @offers("ALMemory.getExtractorEvent")
    def of_extractor(self, extractor: str) -> list[str]:
        """Events declared for an extractor."""
        return sorted(event for event, owner in self._declared.items() if owner == extractor)

    @offers("ALMemory.getEventHistory")
    def history(self, name: str) -> list[list[Any]]:
        """`[[value, [s, us]], ...]` of the last values of an event, oldest first."""
        return list(self._history.get(name, ()))

    _get_event_list = offers("ALMemory.getEventList")(lambda self: sorted(self._declared))
    _get_micro_event_list = offers("ALMemory.getMicroEventList")(lambda self: sorted(self._micro))
    _declare_event = offers("ALMemory.declareEvent")(
        lambda self, name, extractor="": self.declare(name, extractor)
    )
