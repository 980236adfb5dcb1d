"""ALMemory's data: sensors and actuators by name, what programs put in, and what services tell of the robot."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.methods import Table
from bridge.adapters.naoqi.sensors import getters
from bridge.body import Body
from bridge.dcm import Dcm
from bridge.dcm.actuators import short
from bridge.errors import DcmRefused, NaoqiRefused
from bridge.messages import SensorFrame
from bridge.messages.dcm import PREFIX

MAX_DATA: Final = 10_000
"""Keys that programs may put in."""


class Memory:
    """Data of one robot; not thread-safe, the caller locks.

    Args:
        body: Data sheet.
        dcm: Gives the actuators' values and the clock's; may be another one later.
        fixed: Keys that never change.
    """

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
        """Keys whose values are asked for when they are read."""
        self._live.update(values)

    def put(self, key: str, value: Any) -> None:
        """Store a value under a key of the robot's own, and answer the calls that wait for it."""
        self._data[key] = value
        self._stamps[key] = time.time()
        for waiting in self._waiting.pop(key, []):
            waiting.set_result(value)

    def get(self, key: Any) -> Any:
        """The value of a key, with or without the prefix.

        Raises:
            NaoqiRefused: no such key.
        """
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

    def get_list(self, keys: Any) -> list[Any]:
        """Values of several keys; None for each unknown one.

        Raises:
            NaoqiRefused: not a list of names.
        """
        return [self._get_or_none(key) for key in _names(keys, "getListData")]

    def _get_or_none(self, key: str) -> Any:
        try:
            return self.get(key)
        except NaoqiRefused:
            return None

    def insert(self, key: Any, value: Any) -> None:
        """Put data in. On the robot, too, anyone may overwrite a sensor's key, until its next cycle.

        Raises:
            NaoqiRefused: a key of a sensor or an actuator, or too many keys.
        """
        name = text(key, "ALMemory.insertData: key")
        if name in self._known or PREFIX + name in self._known or name in self._live:
            raise NaoqiRefused(f"ALMemory.insertData: {name!r:.80} belongs to the robot; take another name.")
        if name not in self._data and len(self._data) >= MAX_DATA:
            raise NaoqiRefused(f"ALMemory: there are {MAX_DATA} keys already; remove some with removeData.")
        self.put(name, value)

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
        wanted = text(part, "ALMemory.getDataList: filter")
        return [name for name in (*self._names, *self._live, *self._data) if wanted in name]

    def stamped(self, key: Any) -> list[Any]:
        """`[value, s, us]`: a value and the wall-clock time at which it was written; of a sensor now."""
        value = self.get(key)
        whole, part = divmod(self._stamps.get(key, time.time()), 1.0)
        return [value, int(whole), int(1e6 * part)]

    def next_value(self, key: Any, _deprecated: Any = 0) -> Future[Any]:
        """The next value that is written under a key; waits for it."""
        done: Future[Any] = Future()
        if sum(map(len, self._waiting.values())) >= MAX_DATA:
            raise NaoqiRefused(f"ALMemory.getDataOnChange: {MAX_DATA} calls wait already.")
        self._waiting.setdefault(text(key, "ALMemory.getDataOnChange: key"), []).append(done)
        return done

    def describe(self, key: Any, description: Any) -> None:
        """Keep a description of a key."""
        if len(self._descriptions) < MAX_DATA:
            name = text(key, "ALMemory.setDescription: name")
            self._descriptions[name] = text(description, "ALMemory.setDescription: description")

    def descriptions(self, keys: Any) -> list[list[str]]:
        """`[[key, description], ...]` of those that have one."""
        wanted = _names(keys, "getDescriptionList")
        return [[key, self._descriptions[key]] for key in wanted if key in self._descriptions]

    def _type(self, key: Any) -> str:
        kinds = {bool: "Bool", int: "Int", float: "Float", str: "String"}
        return kinds.get(type(self.get(key)), "ALValue")

    def methods(self) -> Table:
        """Methods of `ALMemory` for data; those for events are in `Events`."""
        return {
            "getData": lambda key, *_: self.get(key),
            "getListData": self.get_list,
            "getDataOnChange": self.next_value,
            "insertData": self.insert,
            "insertListData": self.insert_list,
            "removeData": self.remove,
            "getDataList": self.names,
            "getDataListName": self.names,
            "getTimestamp": self.stamped,
            "setDescription": self.describe,
            "getDescriptionList": self.descriptions,
            "getType": self._type,
        }


def _names(keys: Any, method: str) -> list[str]:
    if not isinstance(keys, list) or not all(isinstance(key, str) for key in keys):
        raise NaoqiRefused(f"ALMemory.{method}: {keys!r:.60} was given; a list of names is expected.")
    return keys
