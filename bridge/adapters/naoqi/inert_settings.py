"""Settings of NAOqi without effect here: reflexes, idle motions, autonomous abilities, perception.

Programs set them at their start and read them back. They are remembered; the log says once of each that is
switched on that it has no effect.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag, text
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused

logger = logging.getLogger(__name__)

MOTION: Final[dict[str, Any]] = {
    "IdlePostureEnabled": False,
    "SmartStiffnessEnabled": True,
    "PushRecoveryEnabled": True,
    "DiagnosisEffectEnabled": True,
    "ExternalCollisionProtectionEnabled": True,
    "OrthogonalSecurityDistance": 0.4,
    "TangentialSecurityDistance": 0.1,
}
"""Of `ALMotion`, with what is read before it is set: each has a `set...` and a `get...`. Reflexes are on when a
robot is switched on (confirmed: check_safety_reflexes.py of jrl-umi3218/mc_naoqi_dcm)."""
OF_A_PART: Final = frozenset(
    {
        "IdlePostureEnabled",
        "ExternalCollisionProtectionEnabled",
        "Parameter",
    }
)
"""Settings of one chain, protection or name each, which comes first."""
SETTINGS: Final[dict[str, Mapping[str, Any]]] = {
    "ALAutonomousBlinking": {"Enabled": False},
    "ALBackgroundMovement": {"Enabled": False},
    "ALListeningMovement": {"Enabled": False},
    "ALSpeakingMovement": {"Enabled": False, "Mode": "contextual"},
    "ALAutonomousMoves": {"ExpressiveListeningEnabled": False, "BackgroundStrategy": "none"},
    "ALDarknessDetection": {"DarknessThreshold": 40},
    "ALMovementDetection": {"ColorSensitivity": 0.8, "DepthSensitivity": 0.03},
    "ALNavigation": {"SecurityDistance": 0.4},
    "ALPeoplePerception": {
        "FaceDetectionEnabled": True,
        "FastModeEnabled": False,
        "MaximumDetectionRange": 3.5,
        "MovementDetectionEnabled": True,
        "TimeBeforePersonDisappears": 6.0,
    },
    "ALSoundDetection": {"Parameter": None},
    "ALSoundLocalization": {"Parameter": None},
}
"""Service -> its settings, with what is read before they are set (assumed but for ALNavigation)."""
MAX_KEPT: Final = 1000
"""Settings remembered."""


class InertSettings:
    """Remembers what was set."""

    def __init__(self) -> None:
        self._values: dict[tuple[Any, ...], Any] = {}

    def methods(self, service: str, settings: Mapping[str, Any]) -> Table:
        """`setX`, `getX` and, for `...Enabled`, `isXEnabled`."""
        table: Table = {}
        for name, default in settings.items():
            table[f"set{name}"] = self._setter(service, name, default)
            table[f"get{name}"] = self._getter(service, name, default)
            if name.endswith("Enabled"):
                table[f"is{name}"] = table[f"get{name}"]
        return table

    def _setter(self, service: str, name: str, default: Any) -> Callable[..., bool]:
        where = f"{service}.set{name}"

        def put(*arguments: Any) -> bool:
            """Remember the value, which comes last, behind a part's name if it is one of a part."""
            *of, value = arguments or (None,)
            if len(of) != (name in OF_A_PART) or not arguments:
                raise NaoqiRefused(f"{where} takes {'a name and ' if name in OF_A_PART else ''}one value.")
            part = tuple(text(one, f"{where}: name") for one in of)
            self._put(service, name, part, flag(value, where) if isinstance(default, bool) else value)
            return True

        return put

    def _getter(self, service: str, name: str, default: Any) -> Callable[..., Any]:
        where = f"{service}.get{name}"

        def get(*of: Any) -> Any:
            if len(of) != (name in OF_A_PART):
                raise NaoqiRefused(f"{where} takes {'one name' if name in OF_A_PART else 'nothing'}.")
            return self._values.get((service, name, *(text(one, f"{where}: name") for one in of)), default)

        return get

    def _put(self, service: str, name: str, of: tuple[str, ...], value: Any) -> None:
        key = (service, name, *of)
        if key not in self._values and len(self._values) >= MAX_KEPT:
            return
        if value not in (False, None) and key not in self._values:
            logger.warning("%s.set%s was called; it is remembered and has no effect", service, name)
        self._values[key] = value
