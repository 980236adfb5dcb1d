"""Settings of NAOqi without effect here: reflexes, idle motions, autonomous abilities.

Programs set them at their start and read them back. They are remembered; the log says once of each that is
switched on that it has no effect.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import Any, Final

logger = logging.getLogger(__name__)

MOTION: Final = (
    "BreathEnabled",
    "IdlePostureEnabled",
    "SmartStiffnessEnabled",
    "PushRecoveryEnabled",
    "DiagnosisEffectEnabled",
    "CollisionProtectionEnabled",
    "ExternalCollisionProtectionEnabled",
    "BreathConfig",
    "OrthogonalSecurityDistance",
    "TangentialSecurityDistance",
)
"""Of `ALMotion`: each has a `set...` and a `get...`."""
ABILITIES: Final[dict[str, Sequence[str]]] = {
    "ALAutonomousBlinking": ("Enabled",),
    "ALBackgroundMovement": ("Enabled",),
    "ALBasicAwareness": ("Enabled", "EngagementMode", "TrackingMode", "StimulusDetectionEnabled"),
    "ALListeningMovement": ("Enabled",),
    "ALSpeakingMovement": ("Enabled", "Mode"),
}
"""Service -> its settings."""
MAX_KEPT: Final = 1000
"""Settings remembered."""


class InertSettings:
    """Remembers what was set."""

    def __init__(self) -> None:
        self._values: dict[tuple[Any, ...], Any] = {}

    def methods(self, service: str, names: Sequence[str]) -> dict[str, Callable[..., Any]]:
        """`setX`, `getX` and, for `...Enabled`, `isXEnabled`."""
        table: dict[str, Callable[..., Any]] = {}
        for name in names:
            table[f"set{name}"] = self._setter(service, name)
            table[f"get{name}"] = self._getter(service, name)
            if name.endswith("Enabled"):
                table[f"is{name}"] = table[f"get{name}"]
        return table

    def arms(self) -> dict[str, Callable[..., Any]]:
        """`setMoveArmsEnabled(left, right)` and its older name; read back by arm."""

        def put(left: Any, right: Any) -> None:
            self._put("ALMotion", "MoveArmsEnabled", ("LArm",), left)
            self._put("ALMotion", "MoveArmsEnabled", ("RArm",), right)

        def get(arm: Any = "Arms") -> bool:
            sides = ("LArm", "RArm") if arm == "Arms" else (arm,)
            return all(self._values.get(("ALMotion", "MoveArmsEnabled", side), False) for side in sides)

        return {
            "setMoveArmsEnabled": put,
            "setWalkArmsEnabled": put,
            "getMoveArmsEnabled": get,
            "getWalkArmsEnabled": lambda: [get("LArm"), get("RArm")],
        }

    def _setter(self, service: str, name: str) -> Callable[..., bool]:
        def put(*arguments: Any) -> bool:
            *of, value = arguments or (None,)
            self._put(service, name, tuple(map(str, of)), value)
            return True

        return put

    def _getter(self, service: str, name: str) -> Callable[..., Any]:
        return lambda *of: self._values.get((service, name, *map(str, of)), False)

    def _put(self, service: str, name: str, of: tuple[str, ...], value: Any) -> None:
        key = (service, name, *of)
        if key not in self._values and len(self._values) >= MAX_KEPT:
            return
        if value not in (False, None) and key not in self._values:
            logger.warning("%s.set%s was called; it is remembered and has no effect", service, name)
        self._values[key] = value
