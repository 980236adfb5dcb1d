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
from functools import partial
from typing import Any, Final
from xml.sax.saxutils import quoteattr

from bridge.adapters.naoqi.declared import INERT, Setting, offers
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
"""Memory of the robot's computer (confirmed for V4 and V5: 1 GB)."""


class RobotFacts:
    """`ALSystem`, `ALRobotModel` and `ALConnectionManager`.

    Args:
        config: facts about the robot.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config

    _system_version = offers("ALSystem.systemVersion")(lambda self: self._config.naoqi_version)
    _robot_name = offers("ALSystem.robotName")(lambda self: self._config.name)
    _total_memory = offers("ALSystem.totalMemory")(lambda self: MEMORY_KILOBYTES)
    _free_memory = offers("ALSystem.freeMemory")(lambda self: min(MEMORY_KILOBYTES, _free_kilobytes()))
    _timezone = offers("ALSystem.timezone")(lambda self: time.tzname[0])
    _get_robot_type = offers("ALRobotModel.getRobotType")(lambda self: "Nao")
    _has_legs = offers("ALRobotModel.hasLegs", "ALRobotModel.hasArms")(lambda self: True)
    _has_hands = offers("ALRobotModel.hasHands")(lambda self: self._config.hands)
    _get_config_map = offers("ALRobotModel.getConfigMap", "ALRobotModel._getConfigMap")(
        lambda self: _preferences(self._config)
    )
    _get_microphone_config = offers("ALRobotModel._getMicrophoneConfig")(lambda self: int(MICROPHONES_VERSION))
    _get_config = offers("ALRobotModel.getConfig")(lambda self: _xml(_preferences(self._config)))
    _state = offers("ALConnectionManager.state")(lambda self: "ready")
    _technologies = offers("ALConnectionManager.technologies")(lambda self: ["ethernet"])
    _disk_free = offers("ALSystem.diskFree")(lambda self, every: [["rootfs", "/", *_disk()]])
    _services = offers(
        "ALConnectionManager.services", partly="one wired service, in place of this machine's network"
    )(lambda self: [_WIRED])

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


_MAX_PREFERENCES: Final = 10_000


class Preferences:
    """`ALPreferenceManager`: values of programs by domain and name, for the time of the server."""

    service = "ALPreferenceManager"

    def __init__(self) -> None:
        self._values: dict[str, dict[str, Any]] = {}

    @offers(".setValue", partly="kept for the time of the server")
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
    _update = offers(".update", partly="without effect: there is no cloud")(lambda self: None)


_inert = partial(Setting, partly=INERT, returns=True)


class InertSettings:
    """Settings without effect here.

    Reflexes are on at the start (confirmed: check_safety_reflexes.py of jrl-umi3218/mc_naoqi_dcm); other
    initial values are assumed except for ALNavigation.
    """

    idle_posture_enabled = _inert("ALMotion.IdlePostureEnabled", False, bool, of_part=True)
    smart_stiffness_enabled = _inert("ALMotion.SmartStiffnessEnabled", True, bool)
    push_recovery_enabled = _inert("ALMotion.PushRecoveryEnabled", True, bool)
    diagnosis_effect_enabled = _inert("ALMotion.DiagnosisEffectEnabled", True, bool)
    external_collision_protection_enabled = _inert(
        "ALMotion.ExternalCollisionProtectionEnabled", True, bool, of_part=True
    )
    orthogonal_security_distance = _inert("ALMotion.OrthogonalSecurityDistance", 0.4, float)
    tangential_security_distance = _inert("ALMotion.TangentialSecurityDistance", 0.1, float)
    safeguard_enabled = _inert("ALAutonomousLife.SafeguardEnabled", True, bool, reader="is", of_part=True)
    enabled = _inert("ALAutonomousBlinking.Enabled", False, bool, reader="is")
    background_movement_enabled = _inert("ALBackgroundMovement.Enabled", False, bool, reader="is")
    listening_movement_enabled = _inert("ALListeningMovement.Enabled", False, bool, reader="is")
    speaking_movement_enabled = _inert("ALSpeakingMovement.Enabled", False, bool, reader="is")
    mode = _inert("ALSpeakingMovement.Mode", "contextual", str)
    expressive_listening_enabled = _inert("ALAutonomousMoves.ExpressiveListeningEnabled", False, bool)
    background_strategy = _inert("ALAutonomousMoves.BackgroundStrategy", "none", str)
    darkness_threshold = _inert("ALDarknessDetection.DarknessThreshold", 40, float)
    color_sensitivity = _inert("ALMovementDetection.ColorSensitivity", 0.8, float)
    depth_sensitivity = _inert("ALMovementDetection.DepthSensitivity", 0.03, float)
    security_distance = _inert("ALNavigation.SecurityDistance", 0.4, float)
    face_detection_enabled = _inert("ALPeoplePerception.FaceDetectionEnabled", True, bool, reader="is")
    fast_mode_enabled = _inert("ALPeoplePerception.FastModeEnabled", False, bool, reader="is")
    maximum_detection_range = _inert("ALPeoplePerception.MaximumDetectionRange", 3.5, float)
    movement_detection_enabled = _inert("ALPeoplePerception.MovementDetectionEnabled", True, bool, reader="is")
    time_before_person_disappears = _inert("ALPeoplePerception.TimeBeforePersonDisappears", 6.0, float)
    parameter = _inert("ALSoundDetection.Parameter", None, Any, of_part=True)
    sound_localization_parameter = _inert("ALSoundLocalization.Parameter", None, Any, of_part=True)

    @offers("ALPeoplePerception.resetPopulation")
    def _reset(self) -> None:
        """Without effect: there are no people."""
