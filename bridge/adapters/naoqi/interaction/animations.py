"""ALAnimationPlayer and ALBehaviorManager: gestures of nao-hil in place of the vendor's animations.

The vendor's animations are not published. Each of their names (`animations/Stand/Gestures/Hey_1`) plays a short
gesture of head and arms that fits the name, from the present angles and back.
"""

from __future__ import annotations

import logging
import re
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.core.joint_motion import JointMotion
from bridge.adapters.naoqi.core.joints import Joints
from bridge.adapters.naoqi.declared import INERT, offers
from bridge.errors import NaoqiRefused

logger = logging.getLogger(__name__)

GESTURE_CHAINS: Final = ("Head", "LArm", "RArm")
"""Chains that a gesture may use."""
_NAME: Final = re.compile(r"(?:System/)?(?:animations/)?(?:Stand|Sit|SitOnPod|StandClimb|Lying\w*)/.+")
"""Names of the vendor's animations (vendor's page)."""
_NOD: Final = {"HeadPitch": ((0.3, 0.3), (0.6, -0.1), (0.9, 0.3), (1.2, 0.0))}
_SHAKE: Final = {"HeadYaw": ((0.3, 0.5), (0.7, -0.5), (1.1, 0.5), (1.4, 0.0))}
_WAVE: Final = {
    "RShoulderPitch": ((0.8, -0.8), (2.2, -0.8)),
    "RShoulderRoll": ((0.8, -0.3), (2.2, -0.3)),
    "RElbowRoll": ((0.8, 1.2), (1.2, 0.6), (1.6, 1.2), (2.0, 0.6)),
    "RElbowYaw": ((0.8, 1.2), (2.2, 1.2)),
}
_EXPLAIN: Final = {
    "RShoulderPitch": ((0.6, 0.9), (1.4, 1.1)),
    "RElbowRoll": ((0.6, 1.2), (1.4, 0.9)),
    "LShoulderPitch": ((0.8, 1.0), (1.6, 0.9)),
    "LElbowRoll": ((0.8, -1.2), (1.6, -0.9)),
}
_GESTURES: Final = (
    (re.compile("yes|nod|agree|affirm", re.IGNORECASE), _NOD),
    (re.compile(r"\bno_|/no\b|disagree|never|but_", re.IGNORECASE), _SHAKE),
    (re.compile("hey|hello|hi_|wave|bye|salute|bow", re.IGNORECASE), _WAVE),
)
"""Words of a name, and the gesture for them: joint -> (s, rad)."""
_RETURN_TIME: Final = 0.8
"""Duration of the way back, s."""


def is_animation(name: str) -> bool:
    """Whether a name is one of the vendor's animations."""
    return _NAME.fullmatch(name) is not None


BEHAVIOUR_EVENT: Final = "NaoHil/StartBehavior"
"""Event for a behaviour that a dialogue or a text starts and the robot does not have; its value is the name."""
GESTURES: Final = "the vendor's animations alone are there, and they are gestures of nao-hil"


class Animations:
    """Gestures by the vendor's names; not thread-safe, the caller locks.

    Args:
        joints: of the robot.
        motion: moves them.
    """

    def __init__(self, joints: Joints, motion: JointMotion) -> None:
        self._joints, self._motion = joints, motion
        self._running: dict[str, Future[Any]] = {}
        self._warned = False

    @offers("ALAnimationPlayer.run", kind="joints", partly=GESTURES)
    @offers("ALBehaviorManager.runBehavior", kind="joints", partly=GESTURES)
    def run(self, name: str, *_: Any) -> Future[Any]:
        """Play the gesture for an animation; waits for its end.

        Raises:
            NaoqiRefused: not a name of the vendor's animations.
        """
        if not is_animation(name):
            raise NaoqiRefused(
                f"The behaviour {name!r:.60} is not installed: the vendor's animations alone "
                "(animations/Stand/...) are there; programs that move the joints themselves run."
            )
        if not self._warned:
            self._warned = True
            logger.warning("%s: a gesture of nao-hil is played in its place, as for all animations", name)
        gesture = next((g for words, g in _GESTURES if words.search(name)), _EXPLAIN)
        joints = list(gesture)
        end = max(keys[-1][0] for keys in gesture.values()) + _RETURN_TIME
        angles = [[a for _, a in keys] + [self._joints.commanded(j)] for j, keys in gesture.items()]
        times = [[t for t, _ in keys] + [end] for keys in gesture.values()]
        running = self._motion.angle_interpolation(joints, angles, times, True)
        self._running[name] = running
        return running

    @offers("ALAnimationPlayer.runTag", kind="joints", partly=GESTURES)
    def _run_tag(self, tag: str, *_: Any) -> Future[Any]:
        return self.run(f"animations/Stand/Gestures/{tag}")

    @offers("ALBehaviorManager.startBehavior", kind="joints", partly=GESTURES)
    def _start(self, name: str) -> None:
        self.run(name)

    def _names(self) -> list[str]:
        return [name for name, done in self._running.items() if not done.done()]

    @offers("ALBehaviorManager.isBehaviorRunning", partly=GESTURES)
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

    @offers("ALBehaviorManager.isBehaviorInstalled", "ALBehaviorManager.isBehaviorPresent", partly=GESTURES)
    @offers("ALBehaviorManager.isBehaviorLoaded", partly=GESTURES)
    def _is_installed(self, name: str) -> bool:
        return is_animation(name)

    @offers("ALBehaviorManager.resolveBehaviorName", partly=GESTURES)
    def _resolve(self, name: str) -> str:
        return self._installed(name)

    @offers("ALBehaviorManager.preloadBehavior", partly=GESTURES)
    def _preload(self, name: str) -> bool:
        return bool(self._installed(name))

    @offers("ALAnimationPlayer.declarePathForTags", "ALAnimationPlayer.declareTagForAnimations", partly=INERT)
    def _declare(self, tags: Any) -> None:
        """Without effect."""

    _reset = offers("ALAnimationPlayer.reset")(lambda self: None)
    _get_running_behaviors = offers("ALBehaviorManager.getRunningBehaviors")(lambda self: self._names())
    _lists = offers(
        "ALBehaviorManager.getInstalledBehaviors",
        "ALBehaviorManager.getBehaviorNames",
        "ALBehaviorManager.getLoadedBehaviors",
        "ALBehaviorManager.getDefaultBehaviors",
    )(lambda self: list[Any]())
