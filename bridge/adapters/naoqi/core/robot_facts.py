"""Facts about the robot and its computer: `RobotConfig` keys, ALSystem, ALRobotModel, ALConnectionManager."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final
from xml.sax.saxutils import quoteattr

from bridge.adapters.naoqi.declared import offers
from bridge.body import Body
from bridge.errors import NaoqiRefused

_VERSIONS: Final = {
    "nao-v3": ("V33", "1.14.5"),
    "nao-v3.2": ("V32", "1.14.5"),
    "nao-v3.3": ("V33", "1.14.5"),
    "nao-v4": ("V40", "2.1.4.13"),
    "nao-v5": ("V50", "2.1.4.13"),
    "nao-v6": ("V60", "2.8.5.10"),
}
"""Data sheet -> version of head and body, and of its NAOqi (assumed: one of several)."""


_PARTS: Final = ("Device/LeftArm", "Device/RightArm", "Device/Hand/Left", "Device/Hand/Right", "Device/Legs")
_VERSIONED_PARTS: Final = ("Head", "Body", *(f"Body/{part}" for part in _PARTS))
"""Parts with a key for their version (confirmed: a log of NAOqi 2.1, and the keys of ROS drivers); here the
body's."""


@dataclass(frozen=True)
class RobotConfig:
    """Constant facts about the served robot."""

    body: Body
    name: str

    @property
    def base_version(self) -> str:
        """As in `RobotConfig/Body/BaseVersion`."""
        return _VERSIONS[self.body.base][0]

    @property
    def naoqi_version(self) -> str:
        """Version that `ALSystem.systemVersion` and every module's `version` return."""
        return _VERSIONS[self.body.base][1]

    @property
    def hands(self) -> bool:
        """Whether it has wrists and hands (H25)."""
        return self.body.model == "H25"

    def keys(self) -> dict[str, Any]:
        """ALMemory keys, with their full names."""
        version = self.base_version
        serial = f"NAOHIL{self.body.name.upper()}"
        return {
            "RobotConfig/Body/Type": "Nao",
            "RobotConfig/Body/BaseVersion": version,
            "RobotConfig/Head/BaseVersion": version,
            "RobotConfig/Head/FullHeadId": serial,
            **{f"RobotConfig/{part}/Version": version[1:] for part in _VERSIONED_PARTS},
            "RobotConfig/Head/Device/Micro/Version": "2",  # confirmed: the same log
            "RobotConfig/Body/SoftwareRequirement": self.naoqi_version,
            "Device/DeviceList/ChestBoard/BodyId": serial,
            "Device/DeviceList/ChestBoard/BodyNickName": self.name,
            "Device/DeviceList/ChestBoard/Ack": 0,
            "Device/DeviceList/ChestBoard/Nack": 0,
            "Device/DeviceList/ChestBoard/Error": 0,
            "Device/DeviceList/LeftHandBoard/Available": int(self.hands),
            "Device/DeviceList/RightHandBoard/Available": int(self.hands),
            "Device/DeviceList/TouchBoard/Available": 1,
            "DCM/RealtimeThread": 1,
            "DCM/Simulation": 0,
        }

    def table(self) -> list[list[Any]]:
        """`ALMotion.getRobotConfig`: names and values, as two lists (confirmed: vendor's ALMotion tutorial)."""
        version = f"VERSION_{self.base_version[1:]}"
        rows: list[tuple[str, Any]] = [
            ("Model Type", f"nao{self.body.model}"),
            ("Head Version", version),
            ("Body Version", version),
            ("Laser", False),
            ("Legs", True),
            ("Arms", True),
            ("Extended Arms", False),
            ("Hands", self.hands),
            ("Arm Version", version),
            ("Number of Legs", 2),
            ("Number of Arms", 2),
            ("Number of Hands", 2 if self.hands else 0),
        ]
        return [[name for name, _ in rows], [value for _, value in rows]]


class RobotFacts:
    """`ALSystem`, `ALRobotModel` and `ALConnectionManager`."""

    def __init__(self, config: RobotConfig) -> None:
        self._config = config

    _system_version = offers("ALSystem.systemVersion")(lambda self: self._config.naoqi_version)
    _robot_name = offers("ALSystem.robotName")(lambda self: self._config.name)
    _free_memory = offers("ALSystem.freeMemory")(  # kB
        lambda self: min(1_000_000, os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 1024)
    )
    _timezone = offers("ALSystem.timezone")(lambda self: time.tzname[0])
    _has_hands = offers("ALRobotModel.hasHands")(lambda self: self._config.hands)
    _get_config_map = offers("ALRobotModel.getConfigMap", "ALRobotModel._getConfigMap")(
        lambda self: _preferences(self._config)
    )
    _get_config = offers("ALRobotModel.getConfig")(lambda self: _xml(_preferences(self._config)))
    _disk_free = offers("ALSystem.diskFree")(
        lambda self, every: [["rootfs", "/", *shutil.disk_usage("/")[::2]]]
    )
    _services = offers("ALConnectionManager.services")(lambda self: [_WIRED])

    @offers("ALConnectionManager.service")
    def _service(self, name: Any) -> list[Any]:
        if name != _WIRED[0][1]:
            raise NaoqiRefused(f"ALConnectionManager.service: {name!r:.60} is not there; {_WIRED[0][1]} is.")
        return _WIRED


_WIRED: Final[list[list[Any]]] = [
    *(["ServiceId", "ethernet_wired"], ["Name", "Wired"], ["Type", "ethernet"], ["State", "ready"]),
    *(["Favorite", True], ["Autoconnect", True], ["Security", []], ["Error", ""]),
]
"""The one network service (vendor's page on NetworkInfo)."""


def _preferences(config: RobotConfig) -> dict[str, str]:
    return {key: str(value) for key, value in config.keys().items() if key.startswith("RobotConfig/")}


def _xml(preferences: Mapping[str, str]) -> str:
    """Preferences in the format of NAOqi's configuration files."""
    lines = (
        f'  <Preference memoryName={quoteattr(key)} description="" value={quoteattr(value)} type="string" />'
        for key, value in preferences.items()
    )
    head = '<?xml version="1.0" encoding="UTF-8" ?>\n<ModulePreference name="RobotConfig">'
    return "\n".join([head, *lines, "</ModulePreference>"])


_MAX_PREFERENCES: Final = 10_000


class Preferences:
    """`ALPreferenceManager`: values of programs by domain and name, for the time of the server."""

    service = "ALPreferenceManager"

    def __init__(self) -> None:
        self._values: dict[str, dict[str, Any]] = {}

    @offers(".setValue")
    def _set(self, domain: str, setting: str, value: Any) -> None:
        if sum(map(len, self._values.values())) >= _MAX_PREFERENCES:
            raise NaoqiRefused(f"ALPreferenceManager.setValue: {_MAX_PREFERENCES} values are kept already.")
        self._values.setdefault(domain, {})[setting] = value

    @offers(".getValue")
    def _get(self, domain: str, setting: str) -> Any:
        """The value; None: there is none."""
        return self._values.get(domain, {}).get(setting)

    @offers(".removeValue")
    def _remove(self, domain: str, setting: str) -> None:
        self._values.get(domain, {}).pop(setting, None)

    @offers(".getValueList")
    def _list(self, domain: str) -> list[list[Any]]:
        return [[setting, value] for setting, value in self._values.get(domain, {}).items()]

    @offers(".removeDomainValues")
    def _remove_all(self, domain: str) -> None:
        self._values.pop(domain, None)

    _domains = offers(".getDomainList")(lambda self: list(self._values))
