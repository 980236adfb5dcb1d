"""ALTracker: following visible targets, looking and pointing at places."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Annotated, Any, Final

import numpy as np

from bridge.adapters.naoqi.core.cameras import CAMERAS
from bridge.adapters.naoqi.core.cartesian import look_angles, pointing_angles
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import OneOf, Range, Setting, Vector, flag, fraction, number, offers, text
from bridge.adapters.naoqi.interaction.detection import Scene, Sighting
from bridge.body.cameras import cameras
from bridge.body.kinematics import inverse
from bridge.errors import NaoqiRefused
from bridge.messages.world import ThingKind
from bridge.types import Array, Vec3

PERIOD: Final = 100
"""ms between two views (assumed)."""
HEAD_SPEED: Final = 0.3
"""Fraction of the head's largest speed (assumed)."""
_ORDER_INTERVAL: Final = 400
"""ms between two orders to the walker."""
_MAX_WALK_SPEED: Final = (0.10, 0.4)
"""m/s ahead and rad/s of a walk to a target at most (assumed)."""
_WALK_GAIN: Final = 0.5
"""1/s, of the walk's velocity over distance and angle (assumed)."""
TARGETS: Final[dict[str, ThingKind | None]] = {
    "RedBall": "ball",
    "Face": "face",
    "LandMark": "landmark",
    "LandMarks": "landmark",
    "People": "face",
    "Sound": None,
}
_FACE_DIAMETER: Final = 0.15
"""m; diameter of a person's face (assumed)."""
MODES: Final = ("Head", "WholeBody", "Move")
EFFECTORS: Final = {"None": (), "LArm": ("LArm",), "RArm": ("RArm",), "Arms": ("LArm", "RArm")}
Target = Annotated[str, OneOf("target", TARGETS)]
Position = Annotated[list[float], Vector("x, y, z", -1e3, 1e3, "m")]
Relative = Annotated[list[float], Vector("x, y, theta, dx, dy, dtheta")]


@dataclass(frozen=True)
class FollowedTarget:
    """Description of a target."""

    name: str
    """ALTracker's, for example `RedBall`; or an event's."""
    kind: ThingKind | None
    """None: given by the event, not by a camera."""
    size: float
    """Diameter, m."""
    marks: tuple[str, ...] = ()
    """Numbers of the landmarks to follow; empty: all."""


class Tracker(Service):
    """Methods of `ALTracker`: the head, and arms and walk if wanted, follow one target."""

    _distance = Setting(
        "ALTracker.MaximumDistanceDetection", 1.0, Annotated[float, Range(0.0, 1e3)], inert=True
    )
    _mode = Setting("ALTracker.Mode", "Head", Annotated[str, OneOf("mode", MODES)])
    _effector = Setting("ALTracker.Effector", "None", Annotated[str, OneOf("effector", EFFECTORS)])
    _time_out = Setting("ALTracker.TimeOut", 2000, Annotated[int, Range(0.0, 1e9)])
    """ms after which the target is lost"""
    _relative = Setting("ALTracker.RelativePosition", [0.0] * 6, Relative)
    """Goal of the robot relative to the target: x, y (m), angle (rad), and their tolerances."""

    def __init__(self, robot: ServedRobot, scene: Scene) -> None:
        super().__init__(robot)
        self._scene = scene
        self._cameras = [camera.name for camera in cameras(robot.body)]
        self._target: FollowedTarget | None = None
        self._targets: dict[str, FollowedTarget] = {}
        """Registered."""
        self._place: Array | None = None
        """FRAME_WORLD, (4,)."""
        self._last_history: list[list[Any]] = []
        """Event's history at the last update."""
        self._due = self._seen = self._ordered = 0
        self._lost, self._reached, self._walking = True, False, False

    @offers("ALTracker.initialize")
    def _initialize(self) -> None:
        self.end()
        self._targets = {}
        self._mode, self._effector, self._distance = "Head", "None", 1.0
        self._time_out, self._relative = 2000, [0.0] * 6

    @property
    def lost(self) -> bool:
        """Whether the target is out of sight."""
        return self._target is None or self._lost

    def begin(self, target: FollowedTarget) -> None:
        """Follow a target from now on."""
        self.end()
        self._target, self._place, self._due = target, None, 0
        self._lost, self._reached, self._seen = True, False, -1
        self._last_history = self._events.history(target.name)
        self._events.raise_event("ALTracker/ActiveTargetChanged", target.name)

    @offers("ALTracker.stopTracker")
    def end(self) -> None:
        """Follow nothing; a walk to a target ends."""
        if self._target is not None:
            self._events.raise_event("ALTracker/ActiveTargetChanged", "")
        self._target = None
        self._order((0.0, 0.0, 0.0))

    @offers("ALTracker.getTargetPosition")
    def _position(self, space: Any = 0) -> list[float]:
        """Last place of the target in a space, m; empty: none."""
        if self._place is None:
            return []
        links = self._frames.measured_links()
        to_torso = self._frames.space(1, links, True)
        in_space = inverse(self._frames.space(space, links, True)) @ to_torso @ self._place
        return [float(x) for x in in_space[:3]]

    def place_of(self, target: FollowedTarget) -> list[float]:
        """Last place of a followed target in FRAME_TORSO, m; empty: none."""
        return self._position() if self.follows(target) else []

    def follows(self, target: FollowedTarget) -> bool:
        """Whether this is the target."""
        return self._target == target

    def update(self, now: int) -> None:
        """Follow the target in the cycle at `now` of the robot's clock, ms."""
        if self._target is None or now < self._due:
            return
        self._due = now + PERIOD
        if self._seen < 0:
            self._seen = now
        found = self._find(self._target)
        if found is None:
            if not self._lost and now - self._seen > self._time_out:
                self._lost = True
                self._order((0.0, 0.0, 0.0))
                self._events.raise_event("ALTracker/TargetLost", self._target.name)
            return
        if self._lost:
            self._events.raise_event("ALTracker/TargetDetected", self._target.name)
        self._lost, self._seen = False, now
        self._turn_head(found)
        if self._mode == "Move":
            self._approach(now)

    def _find(self, target: FollowedTarget) -> Array | None:
        """The target in the Torso frame, (4,), m; None: it is out of sight."""
        if target.kind is None:
            return self._place_of_event(target.name)
        for i, name in enumerate(self._cameras):
            for sighting in self._scene.sightings(target.kind, i):
                if not target.marks or sighting.name in target.marks:
                    point: Array = self._frames.in_torso(name, sighting.links) @ point_of(sighting, target.size)
                    self._place = inverse(self._frames.space(1, sighting.links, True)) @ point
                    return point
        return None

    def _place_of_event(self, event: str) -> Array | None:
        """Place in the newest value of an event since the last update, as by `_find`; None: none."""
        history, before = self._events.history(event), self._last_history
        self._last_history = history
        place = history[-1][0] if history and history != before else None
        while isinstance(place, list) and place and isinstance(place[0], list):
            place = place[0]
        if (
            not isinstance(place, list)
            or len(place) < 3
            or not all(isinstance(x, int | float) and abs(x) < 1e3 for x in place[:3])
        ):
            return None
        self._place = np.array((*place[:3], 1.0))
        point: Array = self._frames.space(1, self._frames.measured_links(), True) @ self._place
        return point

    def _turn_head(self, point: Array) -> None:
        camera, place = self._frames.effectors[self._cameras[0]].fixed, [float(x) for x in point[:3]]
        angles = look_angles(place, self._body.lengths.NeckOffsetZ, camera)
        self._motion.set_angles(["HeadYaw", "HeadPitch"], list(angles), HEAD_SPEED)
        for arm in EFFECTORS[self._effector]:
            pointing = pointing_angles(place, arm, self._body.lengths)
            self._motion.set_angles(list(pointing), list(pointing.values()), HEAD_SPEED)

    def _approach(self, now: int) -> None:
        x, y, _ = self._position(2)
        near_x, near_angle = self._relative[3] or 0.1, self._relative[5] or 0.3
        ahead, angle = x + self._relative[0], math.atan2(y, x) + self._relative[2]
        if abs(ahead) < near_x and abs(angle) < near_angle:
            self._order((0.0, 0.0, 0.0))
            if not self._reached:
                self._events.raise_event("ALTracker/TargetReached", self._target.name if self._target else "")
            self._reached = True
            return
        self._reached = False
        if now - self._ordered >= _ORDER_INTERVAL:
            self._ordered = now
            most, turn = _MAX_WALK_SPEED
            speed = max(-most, min(most, _WALK_GAIN * ahead)) if abs(angle) < 2.0 * near_angle else 0.0
            self._order((speed, 0.0, max(-turn, min(turn, _WALK_GAIN * angle))))

    def _order(self, velocity: Vec3) -> None:
        walking, walk = any(velocity), self._robot.walks.get("move")
        if walk is not None and (walking or self._walking):
            walk(*velocity)
        self._walking = walking

    def _point(self, position: Sequence[float], space: Any) -> Sequence[float]:
        """A point in the Torso frame, m."""
        links = self._frames.measured_links()
        x, y, z, _ = self._frames.space(space, links, True) @ (*position, 1.0)
        return float(x), float(y), float(z)

    @offers("ALTracker.lookAt", kind="joints")
    def look_at(self, position: Position, *arguments: Any) -> Future[Any]:
        """Turn the head so that a camera's axis intersects a point; waits for the end.

        Args:
            position: m.
            arguments: `(space, fraction of the largest speed, whole body)`, after the camera's number if given.
                The default space is the torso's (assumed). The head alone turns.
        """
        if len(arguments) == 2:
            arguments = (0, *arguments)
        camera, rest = (arguments[0], arguments[1:]) if len(arguments) == 4 else (0, arguments)
        if len(rest) != 3 or isinstance(camera, bool) or camera not in (0, 1):
            raise NaoqiRefused("ALTracker.lookAt takes ([x, y, z], space, fractionMaxSpeed, useWholeBody).")
        flag(rest[2], "ALTracker.lookAt: useWholeBody")
        share = fraction(rest[1], "ALTracker.lookAt: fractionMaxSpeed")
        point = self._point(position, rest[0])
        place = self._frames.effectors[CAMERAS[camera]].fixed
        angles = look_angles(point, self._body.lengths.NeckOffsetZ, place)
        return self._motion.interpolation_with_speed(["HeadYaw", "HeadPitch"], list(angles), share)

    @offers("ALTracker.pointAt", kind="joints")
    def point_at(
        self, effector: Annotated[str, OneOf("arm", ("LArm", "RArm"))], position: Position, *arguments: Any
    ) -> Future[Any]:
        """Stretch an arm towards a point; waits for the end.

        Args:
            effector: `LArm` or `RArm`.
            position: m.
            arguments: `(space, fraction of the largest speed)`; the space as for `look_at`.
        """
        if len(arguments) not in (1, 2):
            raise NaoqiRefused("ALTracker.pointAt takes (effector, [x, y, z], space, fractionMaxSpeed).")
        space, speed = (0, *arguments)[-2:]
        share = fraction(speed, "ALTracker.pointAt: fractionMaxSpeed")
        point = self._point(position, space)
        angles = pointing_angles(point, effector, self._body.lengths)
        return self._motion.interpolation_with_speed(list(angles), list(angles.values()), share)

    @offers("ALTracker.registerTarget")
    def _register(self, name: Target, parameters: Any = None) -> None:
        self._targets[name] = _target(name, parameters)

    @offers("ALTracker.track", kind="joints")
    def _track(self, name: Target) -> None:
        """Follow a registered target."""
        if name not in self._targets:
            raise NaoqiRefused(f"ALTracker.track: {name} is not registered; call registerTarget first.")
        self.begin(self._targets[name])

    @offers("ALTracker.trackEvent", kind="joints")
    def _track_event(self, event: str) -> None:
        """Follow the places of an event of ALMemory: `[[x, y, z, ...], ...]`, FRAME_WORLD, m."""
        self.begin(FollowedTarget(event, None, 0.0))

    @offers("ALTracker.unregisterAllTargets")
    def _clear(self) -> None:
        self.end()
        self._targets.clear()

    @offers("ALTracker.unregisterTarget", "ALTracker.unregisterTargets")
    def _unregister(self, names: Any) -> None:
        for name in names if isinstance(names, list) else [names]:
            self._targets.pop(text(name, "ALTracker: target"), None)

    _active = offers("ALTracker.getActiveTarget")(lambda self: self._target.name if self._target else "")
    _registered = offers("ALTracker.getRegisteredTargets", "ALTracker.getManagedTargets")(
        lambda self: list(self._targets)
    )
    _is_active = offers("ALTracker.isActive")(lambda self: self._target is not None)
    _is_target_lost = offers("ALTracker.isTargetLost")(lambda self: self.lost)
    _is_new_target_detected = offers("ALTracker.isNewTargetDetected")(lambda self: not self.lost)


def point_of(sighting: Sighting, size: float) -> Array:
    """Place of a thing in the camera's frame, homogeneous, (4,), m.

    Args:
        sighting: Its angles and its angular size in the picture, rad.
        size: Its diameter, m.
    """
    distance = 0.5 * size / math.sin(0.5 * sighting.size)
    across, down = math.tan(sighting.alpha), math.tan(sighting.beta)
    depth = distance / math.sqrt(1.0 + across * across + down * down)
    return np.array((depth, depth * across, -depth * down, 1.0))


class OldTracker:
    """A tracker of NAOqi 1.14, of one kind of target, with the head.

    Args:
        target: ALTracker's name of it.
        size: diameter, m.
    """

    def __init__(self, tracker: Tracker, target: str, size: float) -> None:
        self.service = f"AL{target}Tracker"
        self._tracker, self._target = tracker, _target(target, size)

    _stop_tracker = offers(".stopTracker")(lambda self: self._tracker.end())
    _is_active = offers(".isActive")(lambda self: self._tracker.follows(self._target))
    _is_new_data = offers(".isNewData")(lambda self: self._is_active() and not self._tracker.lost)
    _get_position = offers(".getPosition")(  # zeros: no place (assumed)
        lambda self: self._tracker.place_of(self._target) or [0.0, 0.0, 0.0]
    )
    _start_tracker = offers(".startTracker", kind="joints")(lambda self: self._tracker.begin(self._target))


def _target(name: str, parameters: Any) -> FollowedTarget:
    """A target by its name and the parameter of `registerTarget`: a diameter, with or without marks."""
    if name in ("People", "Sound"):  # registered without a size
        return FollowedTarget(name, TARGETS[name], _FACE_DIAMETER)
    size, marks = parameters, []
    if isinstance(parameters, list) and parameters:
        size = parameters[0]
        marks = parameters[1] if len(parameters) > 1 and isinstance(parameters[1], list) else []
    diameter = number(size, f"ALTracker.registerTarget: size of {name}", 0.001, 10.0)
    return FollowedTarget(name, TARGETS[name], diameter, tuple(str(mark) for mark in marks))
