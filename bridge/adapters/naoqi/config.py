"""What a served robot says it is: `RobotConfig/...` keys, `ALMotion.getRobotConfig`, `ALSystem`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from bridge.body import Body

_VERSIONS: Final = {
    "nao-v3": ("V33", "1.14.5"),
    "nao-v3.2": ("V32", "1.14.5"),
    "nao-v3.3": ("V33", "1.14.5"),
    "nao-v4": ("V40", "2.1.4.13"),
    "nao-v5": ("V50", "2.1.4.13"),
    "nao-v6": ("V60", "2.8.5.10"),
}
"""Data sheet -> version of head and body, and of a NAOqi that ran on it (assumed: one of several)."""


_BODY: Final = ("Device/LeftArm", "Device/RightArm", "Device/Hand/Left", "Device/Hand/Right", "Device/Legs")
_VERSIONED: Final = ("Head", "Body", *(f"Body/{part}" for part in _BODY))
"""Parts whose version is known by a key (confirmed: a log of NAOqi 2.1, and the keys of ROS drivers); here the
body's."""
MICROPHONES: Final = "2"
"""Version of the microphones (confirmed: a log of NAOqi 2.1)."""


@dataclass(frozen=True)
class RobotConfig:
    """Facts about the served robot that never change.

    Args:
        body: Data sheet.
        name: Robot id, which also is its nickname.
    """

    body: Body
    name: str

    @property
    def base_version(self) -> str:
        """As in `RobotConfig/Body/BaseVersion`; a data sheet of one's own counts as a V5."""
        return _VERSIONS.get(self.body.name, ("V50", ""))[0]

    @property
    def naoqi_version(self) -> str:
        """What `ALSystem.systemVersion` and every module's `version` say."""
        return _VERSIONS.get(self.body.name, ("", "2.1.4.13"))[1]

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
            **{f"RobotConfig/{part}/Version": version[1:] for part in _VERSIONED},
            "RobotConfig/Head/Device/Micro/Version": MICROPHONES,
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
