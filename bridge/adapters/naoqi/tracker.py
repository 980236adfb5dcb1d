"""ALTracker: following what the cameras see, and looking and pointing at places."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag, fraction, number, text
from bridge.adapters.naoqi.cartesian import look_angles, pointing_angles
from bridge.adapters.naoqi.following import FollowedTarget, Following
from bridge.adapters.naoqi.frames import RobotFrames
from bridge.adapters.naoqi.joint_motion import JointMotion
from bridge.adapters.naoqi.joints import Joints
from bridge.adapters.naoqi.methods import Method, Table, of_kind
from bridge.errors import NaoqiRefused
from bridge.messages.world import ThingKind
from bridge.validation import unknown_name

TARGETS: Final = ("RedBall", "Face", "LandMark", "LandMarks", "People", "Sound")
_KINDS: Final[dict[str, ThingKind]] = {
    "RedBall": "ball",
    "Face": "face",
    "LandMark": "landmark",
    "LandMarks": "landmark",
}
MODES: Final = ("Head", "WholeBody", "Move")
EFFECTORS: Final = {"None": (), "LArm": ("LArm",), "RArm": ("RArm",), "Arms": ("LArm", "RArm")}
_CAMERAS: Final = ("CameraTop", "CameraBottom")


class Tracker:
    """Methods of `ALTracker`; not thread-safe, the caller locks.

    Args:
        joints: of the robot.
        motion: moves them.
        frames: of the robot.
        following: its loop.
    """

    def __init__(self, joints: Joints, motion: JointMotion, frames: RobotFrames, following: Following) -> None:
        self._joints, self._motion, self._frames, self._following = joints, motion, frames, following
        self._initialize()

    def _initialize(self) -> None:
        self._following.end()
        self._targets: dict[str, FollowedTarget] = {}
        self._mode, self._effector = "Head", "None"
        self._distance = 1.0
        self._following.walks, self._following.time_out = False, 2000
        self._following.relative, self._following.arms = (0.0,) * 6, ()

    def _point(self, position: Any, space: Any, method: str) -> Sequence[float]:
        """A point in the Torso frame, m."""
        if not isinstance(position, list) or len(position) != 3:
            raise NaoqiRefused(f"ALTracker.{method}: {position!r:.60} was given; [x, y, z] in m is expected.")
        place = [number(x, f"ALTracker.{method}: position", -1e3, 1e3) for x in position]
        links = self._frames.measured_links()
        x, y, z, _ = self._frames.space(space, links, True) @ (*place, 1.0)
        return float(x), float(y), float(z)

    def look_at(self, position: Any, *arguments: Any) -> Future[Any]:
        """Turn the head so that a camera's axis goes through a point; waits for the end.

        Args:
            position: m.
            arguments: `(space, fraction of the largest speed, whole body)`, after the camera's number if given.
                Without a space the torso's is meant (assumed). The head alone turns.
        """
        if len(arguments) == 2:
            arguments = (0, *arguments)
        camera, rest = (arguments[0], arguments[1:]) if len(arguments) == 4 else (0, arguments)
        if len(rest) != 3 or isinstance(camera, bool) or camera not in (0, 1):
            raise NaoqiRefused("ALTracker.lookAt takes ([x, y, z], space, fractionMaxSpeed, useWholeBody).")
        flag(rest[2], "ALTracker.lookAt: useWholeBody")
        share = fraction(rest[1], "ALTracker.lookAt: fractionMaxSpeed")
        point = self._point(position, rest[0], "lookAt")
        place = self._frames.effectors[_CAMERAS[camera]].fixed
        angles = look_angles(point, self._joints.body.lengths.NeckOffsetZ, place)
        return self._motion.interpolation_with_speed(["HeadYaw", "HeadPitch"], list(angles), share)

    def point_at(self, effector: Any, position: Any, *arguments: Any) -> Future[Any]:
        """Stretch an arm towards a point; waits for the end.

        Args:
            effector: `LArm` or `RArm`.
            position: m.
            arguments: `(space, fraction of the largest speed)`; the space as for `look_at`.
        """
        if len(arguments) not in (1, 2):
            raise NaoqiRefused("ALTracker.pointAt takes (effector, [x, y, z], space, fractionMaxSpeed).")
        space, speed = (0, *arguments)[-2:]
        arm = text(effector, "ALTracker.pointAt: effector")
        if arm not in ("LArm", "RArm"):
            raise NaoqiRefused(f"ALTracker.pointAt: {arm!r:.40} is no arm; LArm and RArm are.")
        share = fraction(speed, "ALTracker.pointAt: fractionMaxSpeed")
        point = self._point(position, space, "pointAt")
        angles = pointing_angles(point, arm, self._joints.body.lengths)
        return self._motion.interpolation_with_speed(list(angles), list(angles.values()), share)

    def _register(self, name: Any, parameters: Any = None) -> None:
        target = _one_of(name, TARGETS, "target")
        self._targets[target] = _target(target, parameters)

    def track(self, name: Any) -> None:
        """Follow a registered target.

        Raises:
            NaoqiRefused: it is not registered.
        """
        target = _one_of(name, TARGETS, "target")
        if target not in self._targets:
            raise NaoqiRefused(f"ALTracker.track: {target} is not registered; call registerTarget first.")
        self._following.begin(self._targets[target])

    def track_event(self, event: Any) -> None:
        """Follow the places that an event of ALMemory gives: `[[x, y, z, ...], ...]`, FRAME_WORLD, m."""
        name = text(event, "ALTracker.trackEvent: event")
        self._following.begin(FollowedTarget(name, None, 0.0))

    def _clear(self) -> None:
        self._following.end()
        self._targets.clear()

    def _active(self) -> str:
        return self._following.target.name if self._following.target else ""

    def _unregister(self, names: Any) -> None:
        for name in names if isinstance(names, list) else [names]:
            self._targets.pop(text(name, "ALTracker: target"), None)

    def _set_mode(self, mode: Any) -> None:
        wanted = _one_of(mode, MODES, "mode")
        if wanted == "WholeBody":
            raise NaoqiRefused("ALTracker.setMode: WholeBody is not offered; Head and Move are.")
        self._mode, self._following.walks = wanted, wanted == "Move"

    def _set_effector(self, effector: Any) -> None:
        self._effector = _one_of(effector, tuple(EFFECTORS), "effector")
        self._following.arms = EFFECTORS[self._effector]

    def _set_relative(self, position: Any) -> None:
        if not isinstance(position, list) or len(position) != 6:
            raise NaoqiRefused(
                f"ALTracker.setRelativePosition: {position!r:.60} was given; 6 numbers are expected."
            )
        self._following.relative = [number(x, "ALTracker.setRelativePosition: position") for x in position]

    def _set_time_out(self, milliseconds: Any) -> None:
        self._following.time_out = round(number(milliseconds, "ALTracker.setTimeOut: time", 0.0, 1e9))

    def _set_distance(self, distance: Any) -> None:
        self._distance = number(distance, "ALTracker.setMaximumDistanceDetection: distance", 0.0, 1e3)

    def methods(self) -> Table:
        """Methods that move nothing."""
        return {
            "registerTarget": self._register,
            "unregisterTarget": self._unregister,
            "unregisterTargets": self._unregister,
            "unregisterAllTargets": self._clear,
            "getRegisteredTargets": lambda: list(self._targets),
            "getManagedTargets": lambda: list(self._targets),
            "getSupportedTargets": lambda: list(TARGETS),
            "getTargetNames": lambda: list(TARGETS),
            "getAvailableModes": lambda: list(MODES),
            "getMode": lambda: self._mode,
            "setMode": self._set_mode,
            "getEffector": lambda: self._effector,
            "setEffector": self._set_effector,
            "getRelativePosition": lambda: list(self._following.relative),
            "setRelativePosition": self._set_relative,
            "getTimeOut": lambda: self._following.time_out,
            "setTimeOut": self._set_time_out,
            "getMaximumDistanceDetection": lambda: self._distance,
            "setMaximumDistanceDetection": self._set_distance,
            "stopTracker": self._following.end,
            "initialize": self._initialize,
            "isActive": lambda: self._following.target is not None,
            "isTargetLost": lambda: self._following.lost,
            "isNewTargetDetected": lambda: not self._following.lost,
            "getActiveTarget": self._active,
            "getTargetPosition": lambda space=0: self._following.position(space),
        }

    def old_methods(self, target: str, size: float) -> dict[str, Method]:
        """Methods of a tracker of NAOqi 1.14, which follows one kind of target with the head.

        Args:
            target: ALTracker's name of it.
            size: diameter, m.
        """
        followed = _target(target, size)

        def active() -> bool:
            return self._following.target == followed

        def place() -> list[float]:
            """Where it was seen last in FRAME_TORSO, m; zeros: never (assumed)."""
            return (self._following.position(0) if active() else []) or [0.0, 0.0, 0.0]

        reading: Table = {
            "stopTracker": self._following.end,
            "isActive": active,
            "isNewData": lambda: active() and not self._following.lost,
            "getPosition": place,
            "setWholeBodyOn": lambda on: flag(on, f"AL{target}Tracker.setWholeBodyOn: on") and None,
        }
        return of_kind("read", reading) | of_kind(
            "joints", {"startTracker": lambda: self._following.begin(followed)}
        )

    def moving(self) -> Table:
        """Methods that command joints."""
        return {
            "lookAt": self.look_at,
            "pointAt": self.point_at,
            "track": self.track,
            "trackEvent": self.track_event,
        }


def _target(name: str, parameters: Any) -> FollowedTarget:
    """A target by its name and what `registerTarget` takes for it: a diameter, or that and numbers of marks."""
    if name not in _KINDS:
        raise NaoqiRefused(f"ALTracker.registerTarget: {name} cannot be perceived; {', '.join(_KINDS)} can.")
    kind = _KINDS[name]
    size, marks = parameters, []
    if isinstance(parameters, list) and parameters:
        size = parameters[0]
        marks = parameters[1] if len(parameters) > 1 and isinstance(parameters[1], list) else []
    diameter = number(size, f"ALTracker.registerTarget: size of {name}", 0.001, 10.0)
    return FollowedTarget(name, kind, diameter, tuple(str(mark) for mark in marks))


def _one_of(name: Any, known: Sequence[str], what: str) -> str:
    chosen = text(name, f"ALTracker: {what}")
    if chosen not in known:
        raise NaoqiRefused(f"ALTracker: {unknown_name(what, chosen, known)}.")
    return chosen
