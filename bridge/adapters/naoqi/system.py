"""ALSystem, ALRobotModel and ALPreferenceManager: facts about the robot, and settings that programs keep."""

from __future__ import annotations

import time
from typing import Any, Final

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.config import RobotConfig
from bridge.adapters.naoqi.methods import Method, Table, of_kind
from bridge.errors import NaoqiRefused

MAX_PREFERENCES: Final = 10_000


class Preferences:
    """`ALPreferenceManager`: values by domain and name, as long as the server runs; the caller locks."""

    def __init__(self) -> None:
        self._values: dict[str, dict[str, Any]] = {}

    def put(self, domain: Any, name: Any, value: Any) -> None:
        """Keep a value.

        Raises:
            NaoqiRefused: not names, or too many values.
        """
        where, what = _name(domain, "domain"), _name(name, "setting")
        if sum(map(len, self._values.values())) >= MAX_PREFERENCES:
            raise NaoqiRefused(f"ALPreferenceManager: {MAX_PREFERENCES} values are kept already; remove some.")
        self._values.setdefault(where, {})[what] = value

    def get(self, domain: Any, name: Any) -> Any:
        """A value, or None when there is none."""
        return self._values.get(_name(domain, "domain"), {}).get(_name(name, "setting"))

    def _put_all(self, values: Any) -> None:
        if not isinstance(values, dict) or not all(isinstance(of, dict) for of in values.values()):
            raise NaoqiRefused(
                f"ALPreferenceManager.setValues: {values!r:.60} was given; {{domain: {{setting: value}}}} "
                "is expected."
            )
        for domain, settings in values.items():
            for name, value in settings.items():
                self.put(domain, name, value)

    def _list(self, domain: Any) -> list[list[Any]]:
        return [[name, value] for name, value in self._values.get(_name(domain, "domain"), {}).items()]

    def methods(self) -> Table:
        """Methods of the service."""
        return {
            "getValue": self.get,
            "setValue": self.put,
            "setValues": self._put_all,
            "getValueList": self._list,
            "getDomainList": lambda: sorted(self._values),
            "removeValue": lambda domain, name: _drop(self._values.get(_name(domain, "domain"), {}), name),
            "removeDomainValues": lambda domain: _drop(self._values, domain),
            "update": lambda: None,
        }


def system_services(config: RobotConfig, memory_kilobytes: int = 1_000_000) -> dict[str, dict[str, Method]]:
    """Service -> methods.

    Args:
        config: facts about the robot.
        memory_kilobytes: that the robot's computer has (confirmed for V4 and V5: 1 GB).
    """
    tables: dict[str, Table] = {
        "ALSystem": {
            "systemVersion": lambda: config.naoqi_version,
            "robotName": lambda: config.name,
            "totalMemory": lambda: memory_kilobytes,
            "timezone": lambda: time.tzname[0],
        },
        "ALRobotModel": {
            "getRobotType": lambda: "Nao",
            "hasLegs": lambda: True,
            "hasArms": lambda: True,
            "hasHands": lambda: config.hands,
        },
        "ALPreferenceManager": Preferences().methods(),
    }
    return {name: of_kind("read", table) for name, table in tables.items()}


def _name(value: Any, what: str) -> str:
    return text(value, f"ALPreferenceManager: {what}")


def _drop(values: dict[str, Any], name: Any) -> None:
    values.pop(_name(name, "name"), None)
