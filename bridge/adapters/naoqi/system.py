"""Facts about the robot and its computer, and settings that programs keep: ALSystem and others."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Container, Mapping
from typing import Any, Final
from xml.sax.saxutils import quoteattr

from bridge.adapters.naoqi.arguments import flag, text
from bridge.adapters.naoqi.config import MICROPHONES, RobotConfig
from bridge.adapters.naoqi.methods import Method, Table, of_kind
from bridge.errors import NaoqiRefused

MAX_PREFERENCES: Final = 10_000
MEMORY_KILOBYTES: Final = 1_000_000
"""Of the robot's computer (confirmed for V4 and V5: 1 GB)."""


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


def system_services(
    config: RobotConfig, services: Callable[[], Container[str]]
) -> dict[str, dict[str, Method]]:
    """Service -> methods.

    Args:
        config: facts about the robot.
        services: that the robot has.
    """
    notifies = [True]

    def notify(enabled: Any) -> None:
        notifies[0] = flag(enabled, "ALDiagnosis.setEnableNotification: enabled")

    def launch(module: Any) -> list[str]:
        """Modules that were loaded for this one: none, since it is there already."""
        name = text(module, "ALLauncher.launchLocal: module")
        if name not in services():
            raise NaoqiRefused(
                f"ALLauncher.launchLocal: {name!r:.60} is not there, and no module can be loaded."
            )
        return []

    tables: dict[str, Table] = {
        "ALSystem": {
            "systemVersion": lambda: config.naoqi_version,
            "robotName": lambda: config.name,
            "totalMemory": lambda: MEMORY_KILOBYTES,
            "freeMemory": lambda: min(MEMORY_KILOBYTES, _free_kilobytes()),
            "diskFree": lambda _all: [["rootfs", "/", *_disk()]],
            "timezone": lambda: time.tzname[0],
        },
        "ALRobotModel": {
            "getRobotType": lambda: "Nao",
            "hasLegs": lambda: True,
            "hasArms": lambda: True,
            "hasHands": lambda: config.hands,
            "getConfigMap": lambda: _preferences(config),
            "_getConfigMap": lambda: _preferences(config),
            "_getMicrophoneConfig": lambda: int(MICROPHONES),
            "getConfig": lambda: _xml(_preferences(config)),
        },
        "ALConnectionManager": {
            "state": lambda: "ready",
            "scan": lambda technology="": text(technology, "ALConnectionManager.scan: technology") and None,
            "technologies": lambda: ["ethernet"],
            "services": lambda: [_WIRED],
            "service": _service,
            "getTetheringEnable": lambda of: not text(of, "ALConnectionManager: technology") and False,
        },
        "ALDiagnosis": {
            "getActiveDiagnosis": lambda: [0, []],
            "getPassiveDiagnosis": lambda: [0, []],
            "isNotificationEnabled": lambda: notifies[0],
            "setEnableNotification": notify,
        },
        "ALLauncher": {"launchLocal": launch},
        "ALUserSession": _users(),
        "ALPreferenceManager": Preferences().methods(),
    }
    return {name: of_kind("read", table) for name, table in tables.items()}


_WIRED: Final[list[list[Any]]] = [
    ["ServiceId", "ethernet_wired"],
    ["Name", "Wired"],
    ["Type", "ethernet"],
    ["State", "ready"],
    ["Favorite", True],
    ["Autoconnect", True],
    ["Security", []],
    ["Error", ""],
]
"""The one network service: how programs reach the robot (vendor's page on NetworkInfo)."""


def _service(name: Any) -> list[Any]:
    if name != _WIRED[0][1]:
        raise NaoqiRefused(f"ALConnectionManager.service: {name!r:.60} is not there; {_WIRED[0][1]} is.")
    return _WIRED


def _users() -> Table:
    """Of `ALUserSession`: the robot has met nobody."""

    def nobody(user: Any, *_: Any) -> None:
        raise NaoqiRefused(f"ALUserSession: there is no user {user!r:.40}; the robot has met nobody.")

    def none_of(users: Any) -> bool:
        """Whether all of them are known: only of an empty list."""
        return isinstance(users, list) and not users

    lists = ("getUserList", "getOpenUserSessions", "getBindingSources", "getUserDataSources")
    table: Table = {name: lambda: [] for name in lists}
    return table | {
        "getNumUsers": lambda: 0,
        "getFocusedUser": lambda: -1,
        "doUsersExist": none_of,
        "areUserSessionsOpen": none_of,
        "doesBindingSourceExist": lambda name: text(name, "ALUserSession: source") == "",
        "doesUserDataSourceExist": lambda name: text(name, "ALUserSession: source") == "",
        "findUsersWithBinding": lambda name, value: [],
        **{name: nobody for name in ("getUserBinding", "getUserBindings", "getUserData")},
    }


def _free_kilobytes() -> int:
    """Memory of this machine that is free."""
    return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 1024


def _disk() -> tuple[int, int]:
    """Size of this machine's root file system, and what is free of it, bytes."""
    usage = shutil.disk_usage("/")
    return usage.total, usage.free


def _preferences(config: RobotConfig) -> dict[str, str]:
    return {key: str(value) for key, value in config.keys().items() if key.startswith("RobotConfig/")}


def _xml(preferences: Mapping[str, str]) -> str:
    """Preferences as NAOqi's configuration files have them."""
    lines = (
        f'  <Preference memoryName={quoteattr(key)} description="" value={quoteattr(value)} type="string" />'
        for key, value in preferences.items()
    )
    head = '<?xml version="1.0" encoding="UTF-8" ?>\n<ModulePreference name="RobotConfig">'
    return "\n".join([head, *lines, "</ModulePreference>"])


def _name(value: Any, what: str) -> str:
    return text(value, f"ALPreferenceManager: {what}")


def _drop(values: dict[str, Any], name: Any) -> None:
    values.pop(_name(name, "name"), None)
