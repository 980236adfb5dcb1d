"""ALAnimationPlayer and ALBehaviorManager: gestures of our own stand for the vendor's animations.

The vendor's animations are not published. Each of their names (`animations/Stand/Gestures/Hey_1`) plays a short
gesture of head and arms that fits the name, from where the joints are and back.
"""

from __future__ import annotations

import logging
import re
from concurrent.futures import Future
from typing import Any, Final, NoReturn

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.core.joint_motion import JointMotion
from bridge.adapters.naoqi.core.joints import Joints
from bridge.adapters.naoqi.methods import Method, Table, of_kind
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
_BACK: Final = 0.8
"""s for the way back."""


def is_animation(name: str) -> bool:
    """Whether a name is one of the vendor's animations."""
    return _NAME.fullmatch(name) is not None


class Animations:
    """Not thread-safe, the caller locks.

    Args:
        joints: of the robot.
        motion: moves them.
    """

    def __init__(self, joints: Joints, motion: JointMotion) -> None:
        self._joints, self._motion = joints, motion
        self._running: dict[str, Future[Any]] = {}
        self._warned = False

    def run(self, name: Any, *_: Any) -> Future[Any]:
        """Play the gesture for an animation; waits for its end.

        Raises:
            NaoqiRefused: no animation of the vendor has a name of this form.
        """
        animation = text(name, "ALAnimationPlayer.run: name")
        if not is_animation(animation):
            raise NaoqiRefused(
                f"The behaviour {animation!r:.60} is not installed: the vendor's animations alone "
                "(animations/Stand/...) are there; programs that move the joints themselves run."
            )
        if not self._warned:
            self._warned = True
            logger.warning("%s: a gesture of nao-hil is played in its place, as for all animations", animation)
        gesture = next((g for words, g in _GESTURES if words.search(animation)), _EXPLAIN)
        joints = list(gesture)
        end = max(keys[-1][0] for keys in gesture.values()) + _BACK
        angles = [[a for _, a in keys] + [self._joints.commanded(j)] for j, keys in gesture.items()]
        times = [[t for t, _ in keys] + [end] for keys in gesture.values()]
        running = self._motion.angle_interpolation(joints, angles, times, True)
        self._running[animation] = running
        return running

    def _run_tag(self, tag: Any, *_: Any) -> Future[Any]:
        return self.run(f"animations/Stand/Gestures/{text(tag, 'ALAnimationPlayer.runTag: tag')}")

    def _start(self, name: Any) -> None:
        self.run(name)

    def _names(self) -> list[str]:
        return [name for name, done in self._running.items() if not done.done()]

    def _is_running(self, name: Any) -> bool:
        return text(name, "ALBehaviorManager.isBehaviorRunning: name") in self._names()

    def _stop(self, name: Any) -> None:
        """Stop a behaviour; nothing happens if it does not run."""
        if self._is_running(name):
            self._motion.end_using(list(GESTURE_CHAINS))

    def _stop_all(self) -> None:
        if self._names():
            self._motion.end_using(list(GESTURE_CHAINS))

    def methods(self) -> dict[str, Method]:
        """Methods of `ALAnimationPlayer`."""
        reading: Table = {
            "declarePathForTags": lambda path: (
                text(path, "ALAnimationPlayer.declarePathForTags: path") and None
            ),
            "declareTagForAnimations": lambda tags: tags and None,
            "reset": lambda: None,
        }
        return of_kind("joints", {"run": self.run, "runTag": self._run_tag}) | of_kind("read", reading)

    def behavior_methods(self) -> dict[str, Method]:
        """Methods of `ALBehaviorManager`: a behaviour that is no animation fails as documented."""

        def absent(method: str) -> Any:
            """A method that refuses a behaviour by its name."""

            def fail(name: Any, *_: Any) -> NoReturn:
                behavior = text(name, f"ALBehaviorManager.{method}: name")
                raise NaoqiRefused(
                    f"ALBehaviorManager.{method}: the behaviour {behavior!r:.60} is not installed."
                )

            return fail

        def installed(name: Any) -> bool:
            return is_animation(text(name, "ALBehaviorManager: name"))

        lists = (
            *("getInstalledBehaviors", "getBehaviorNames", "getSystemBehaviorNames", "getUserBehaviorNames"),
            *("getLoadedBehaviors", "getDefaultBehaviors", "getTagList"),
        )
        of_a_name = ("addDefaultBehavior", "getBehaviorTags", "getBehaviorNature", "removeBehavior")
        reading: Table = {
            **{name: lambda: [] for name in lists},
            **{f"isBehavior{state}": installed for state in ("Installed", "Present", "Loaded")},
            **{name: absent(name) for name in of_a_name},
            "isBehaviorRunning": self._is_running,
            "getRunningBehaviors": self._names,
            "resolveBehaviorName": lambda name: (
                name if installed(name) else absent("resolveBehaviorName")(name)
            ),
            "preloadBehavior": lambda name: installed(name) or absent("preloadBehavior")(name),
            "removeDefaultBehavior": lambda name: text(name, "ALBehaviorManager: name") and None,
            "playDefaultProject": lambda: None,
            "getBehaviorsByTag": lambda tag: text(tag, "ALBehaviorManager.getBehaviorsByTag: tag") and [],
            "stopBehavior": self._stop,
            "stopAllBehaviors": self._stop_all,
        }
        return of_kind("read", reading) | of_kind(
            "joints", {"runBehavior": self.run, "startBehavior": self._start}
        )
