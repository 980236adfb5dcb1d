"""Facts about the robot and its computer: ALSystem, ALRobotModel and ALConnectionManager."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Mapping
from typing import Any, Final
from xml.sax.saxutils import quoteattr

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.config import MICROPHONES, RobotConfig
from bridge.adapters.naoqi.methods import Method, Table, of_kind
from bridge.errors import NaoqiRefused

MEMORY_KILOBYTES: Final = 1_000_000
"""Of the robot's computer (confirmed for V4 and V5: 1 GB)."""


def system_services(config: RobotConfig) -> dict[str, dict[str, Method]]:
    """Service -> methods.

    Args:
        config: facts about the robot.
    """
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
