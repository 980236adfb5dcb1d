"""Settings of NAOqi without effect here: reflexes, idle motions, autonomous abilities, perception.

Programs set them at their start and read them back. They are remembered; the log says once of each that is
switched on that it has no effect.
"""

from __future__ import annotations

from typing import Any, Final

from bridge.adapters.naoqi.declared import KEPT, Setting, offers

_READ_BY_GET: Final = ("ALMotion", "ALAutonomousMoves")
"""Services whose switches are read with `get...`; those of others with `is...`."""
_OF_A_PART: Final = ("IdlePostureEnabled", "ExternalCollisionProtectionEnabled", "Parameter")
"""Settings of one chain, protection or name each, which comes first."""
_SETTINGS: Final[dict[str, Any]] = {
    "ALMotion.IdlePostureEnabled": False,
    "ALMotion.SmartStiffnessEnabled": True,
    "ALMotion.PushRecoveryEnabled": True,
    "ALMotion.DiagnosisEffectEnabled": True,
    "ALMotion.ExternalCollisionProtectionEnabled": True,
    "ALMotion.OrthogonalSecurityDistance": 0.4,
    "ALMotion.TangentialSecurityDistance": 0.1,
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
"""Setting -> its value before it is set; its type is the setting's. Reflexes are on when a robot is switched on
(confirmed: check_safety_reflexes.py of jrl-umi3218/mc_naoqi_dcm); others are assumed but for ALNavigation."""


def _setting(name: str, default: Any) -> Setting:
    service, _, setting = name.partition(".")
    kind = {bool: bool, int: float, float: float, str: str}.get(type(default), Any)
    reader = "is" if kind is bool and service not in _READ_BY_GET else "get"
    part = setting in _OF_A_PART
    return Setting(name, default, kind, KEPT, reader=reader, returns=True, of_part=part)


class _Others:
    @offers("ALPeoplePerception.resetPopulation")
    def _reset(self) -> None:
        """Forget all people; there are none."""


InertSettings = type(
    "InertSettings", (_Others,), {name.replace(".", "_"): _setting(name, of) for name, of in _SETTINGS.items()}
)
