"""Facts about the robot and its computer: `RobotConfig` keys, ALSystem, ALRobotModel, ALConnectionManager.

And settings without effect here (reflexes, idle motions, autonomous abilities, perception), which programs set
at their start and read back. They are remembered; the log warns once of each that is switched on.
"""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final
from xml.sax.saxutils import quoteattr

from bridge.adapters.naoqi.declared import INERT, Answers, Setting, offers
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
MICROPHONES_VERSION: Final = "2"
"""Version of the microphones (confirmed: a log of NAOqi 2.1)."""


@dataclass(frozen=True)
class RobotConfig:
    """Constant facts about the served robot.

    Args:
        body: Data sheet.
        name: Robot id, which also is its nickname.
    """

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
            "RobotConfig/Head/Device/Micro/Version": MICROPHONES_VERSION,
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


MEMORY_KILOBYTES: Final = 1_000_000
"""Of the robot's computer (confirmed for V4 and V5: 1 GB)."""


class RobotFacts:
    """`ALSystem`, `ALRobotModel` and `ALConnectionManager`.

    Args:
        config: facts about the robot.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config

    answers = Answers(
        {
            "ALSystem.systemVersion": lambda self: self._config.naoqi_version,
            "ALSystem.robotName": lambda self: self._config.name,
            "ALSystem.totalMemory": lambda self: MEMORY_KILOBYTES,
            "ALSystem.freeMemory": lambda self: min(MEMORY_KILOBYTES, _free_kilobytes()),
            "ALSystem.timezone": lambda self: time.tzname[0],
            "ALRobotModel.getRobotType": lambda self: "Nao",
            "ALRobotModel.hasLegs": lambda self: True,
            "ALRobotModel.hasArms": lambda self: True,
            "ALRobotModel.hasHands": lambda self: self._config.hands,
            "ALRobotModel.getConfigMap": lambda self: _preferences(self._config),
            "ALRobotModel._getConfigMap": lambda self: _preferences(self._config),
            "ALRobotModel._getMicrophoneConfig": lambda self: int(MICROPHONES_VERSION),
            "ALRobotModel.getConfig": lambda self: _xml(_preferences(self._config)),
            "ALConnectionManager.state": lambda self: "ready",
            "ALConnectionManager.technologies": lambda self: ["ethernet"],
            "ALSystem.diskFree": lambda self, every: [["rootfs", "/", *_disk()]],
        }
    )
    network = Answers(
        {"ALConnectionManager.services": lambda self: [_WIRED]},
        partly="one wired service, in place of this machine's network",
    )

    @offers("ALConnectionManager.scan", partly="nothing is looked for")
    def _scan(self, technology: str = "") -> None:
        """Without effect."""

    @offers("ALConnectionManager.service", partly="as services")
    def _service(self, name: Any) -> list[Any]:
        if name != _WIRED[0][1]:
            raise NaoqiRefused(f"ALConnectionManager.service: {name!r:.60} is not there; {_WIRED[0][1]} is.")
        return _WIRED

    @offers("ALConnectionManager.getTetheringEnable")
    def _tethers(self, technology: str) -> bool:
        return False


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
"""The one network service (vendor's page on NetworkInfo)."""


def _free_kilobytes() -> int:
    """Free memory of this machine."""
    return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 1024


def _disk() -> tuple[int, int]:
    """Size of this machine's root file system, and its free space, bytes."""
    usage = shutil.disk_usage("/")
    return usage.total, usage.free


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


_GET_READERS: Final = ("ALMotion", "ALAutonomousMoves")
"""Services with readers `get...` of their switches; others have `is...`."""
_OF_A_PART: Final = (
    *("IdlePostureEnabled", "ExternalCollisionProtectionEnabled", "SafeguardEnabled"),
    *("Parameter",),
)
"""Settings of a chain, protection or name, which is the first argument."""
_SETTINGS: Final[dict[str, Any]] = {
    "ALMotion.IdlePostureEnabled": False,
    "ALMotion.SmartStiffnessEnabled": True,
    "ALMotion.PushRecoveryEnabled": True,
    "ALMotion.DiagnosisEffectEnabled": True,
    "ALMotion.ExternalCollisionProtectionEnabled": True,
    "ALMotion.OrthogonalSecurityDistance": 0.4,
    "ALMotion.TangentialSecurityDistance": 0.1,
    "ALAutonomousLife.SafeguardEnabled": True,
    "ALAutonomousBlinking.Enabled": False,
    "ALBackgroundMovement.Enabled": False,
    "ALListeningMovement.Enabled": False,
    "ALSpeakingMovement.Enabled": False,
    "ALSpeakingMovement.Mode": "contextual",
    "ALAutonomousMoves.ExpressiveListeningEnabled": False,
    "ALAutonomousMoves.BackgroundStrategy": "none",
    "ALDarknessDetection.DarknessThreshold": 40,
    "ALMovementDetection.ColorSensitivity": 0.8,
    "ALMovementDetection.DepthSensitivity": 0.03,
    "ALNavigation.SecurityDistance": 0.4,
    "ALPeoplePerception.FaceDetectionEnabled": True,
    "ALPeoplePerception.FastModeEnabled": False,
    "ALPeoplePerception.MaximumDetectionRange": 3.5,
    "ALPeoplePerception.MovementDetectionEnabled": True,
    "ALPeoplePerception.TimeBeforePersonDisappears": 6.0,
    "ALSoundDetection.Parameter": None,
    "ALSoundLocalization.Parameter": None,
}
"""Setting -> its initial value, which has the setting's type. Reflexes are on at the start (confirmed:
check_safety_reflexes.py of jrl-umi3218/mc_naoqi_dcm); others are assumed except for ALNavigation."""


def _setting(name: str, default: Any) -> Setting:
    service, _, setting = name.partition(".")
    kind = {bool: bool, int: float, float: float, str: str}.get(type(default), Any)
    reader = "is" if kind is bool and service not in _GET_READERS else "get"
    part = setting in _OF_A_PART
    return Setting(name, default, kind, INERT, reader=reader, returns=True, of_part=part)


class _Others:
    @offers("ALPeoplePerception.resetPopulation")
    def _reset(self) -> None:
        """Without effect: there are no people."""


InertSettings = type(
    "InertSettings", (_Others,), {name.replace(".", "_"): _setting(name, of) for name, of in _SETTINGS.items()}
)
