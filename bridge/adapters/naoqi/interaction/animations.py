"""ALAnimationPlayer and ALBehaviorManager: gestures of nao-hil in place of the vendor's animations.

The vendor's animations are not published. Each of their names (`animations/Stand/Gestures/Hey_1`) plays a short
gesture of head and arms that fits the name, from the present angles and back.
"""

from __future__ import annotations

import logging
import re
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import offers
from bridge.config import read_toml
from bridge.errors import NaoqiRefused
from bridge.validation import convert

logger = logging.getLogger(__name__)

GESTURE_CHAINS: Final = ("Head", "LArm", "RArm")
"""Chains that a gesture may use."""
_NAME: Final = re.compile(r"(?:System/)?(?:animations/)?(?:Stand|Sit|SitOnPod|StandClimb|Lying\w*)/.+")
"""Names of the vendor's animations (vendor's page)."""


class _Gesture(msgspec.Struct, frozen=True):
    words: str
    joints: dict[str, list[tuple[float, float]]]


_GESTURES: Final = convert(read_toml(Path(__file__).with_name("gestures.toml"))["gesture"], list[_Gesture])
_RETURN_TIME: Final = 0.8
"""Duration of the way back, s."""


def is_animation(name: str) -> bool:
    """Whether a name is one of the vendor's animations."""
    return _NAME.fullmatch(name) is not None


BEHAVIOUR_EVENT: Final = "NaoHil/StartBehavior"
"""Event for a behaviour that a dialogue or a text starts and the robot does not have; its value is the name."""


class Animations(Service):
    """Gestures by the vendor's names."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._running: dict[str, Future[Any]] = {}
        self._warned = False

    @offers("ALAnimationPlayer.run", "ALBehaviorManager.runBehavior", kind="joints")
    def run(self, name: str, *_: Any) -> Future[Any]:
        """Play the gesture for an animation; waits for its end."""
        if not is_animation(name):
            raise NaoqiRefused(
                f"The behaviour {name!r:.60} is not installed: the vendor's animations alone "
                "(animations/Stand/...) are there; programs that move the joints themselves run."
            )
        if not self._warned:
            self._warned = True
            logger.warning("%s: a gesture of nao-hil is played in its place, as for all animations", name)
        gesture = next(g for g in _GESTURES if re.search(g.words, name, re.IGNORECASE)).joints
        joints = list(gesture)
        end = max(keys[-1][0] for keys in gesture.values()) + _RETURN_TIME
        angles = [[a for _, a in keys] + [self._joints.commanded(j)] for j, keys in gesture.items()]
        times = [[t for t, _ in keys] + [end] for keys in gesture.values()]
        running = self._motion.angle_interpolation(joints, angles, times, True)
        self._running[name] = running
        return running

    @offers("ALAnimationPlayer.runTag", kind="joints")
    def _run_tag(self, tag: str, *_: Any) -> Future[Any]:
        return self.run(f"animations/Stand/Gestures/{tag}")

    @offers("ALBehaviorManager.startBehavior", kind="joints")
    def _start(self, name: str) -> None:
        self.run(name)

    def _names(self) -> list[str]:
        return [name for name, done in self._running.items() if not done.done()]

    @offers("ALBehaviorManager.isBehaviorRunning")
    def _is_running(self, name: str) -> bool:
        return name in self._names()

    @offers("ALBehaviorManager.stopBehavior")
    def _stop(self, name: str) -> None:
        """Stop a behaviour, if it runs."""
        if self._is_running(name):
            self._motion.end_using(list(GESTURE_CHAINS))

    @offers("ALBehaviorManager.stopAllBehaviors")
    def _stop_all(self) -> None:
        if self._names():
            self._motion.end_using(list(GESTURE_CHAINS))

    def _installed(self, name: str) -> str:
        if not is_animation(name):
            raise NaoqiRefused(f"ALBehaviorManager: the behaviour {name!r:.60} is not installed.")
        return name

    @offers("ALBehaviorManager.isBehaviorInstalled", "ALBehaviorManager.isBehaviorPresent")
    @offers("ALBehaviorManager.isBehaviorLoaded")
    def _is_installed(self, name: str) -> bool:
        return is_animation(name)

    @offers("ALBehaviorManager.resolveBehaviorName")
    def _resolve(self, name: str) -> str:
        return self._installed(name)

    @offers("ALBehaviorManager.preloadBehavior")
    def _preload(self, name: str) -> bool:
        return bool(self._installed(name))

    _get_running_behaviors = offers("ALBehaviorManager.getRunningBehaviors")(lambda self: self._names())
