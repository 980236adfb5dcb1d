"""A target that the cameras see is followed, with the head or by walking: the loop behind ALTracker.

The place of a target follows from the angles at which it is seen and from its known size (vendor's pages on
ALTracker), or an event of ALMemory tells it. The head turns so that the top camera looks at it, and arms point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from bridge.adapters.naoqi.cartesian import look_angles, pointing_angles
from bridge.adapters.naoqi.events import Events
from bridge.adapters.naoqi.frames import RobotFrames
from bridge.adapters.naoqi.joint_motion import JointMotion
from bridge.adapters.naoqi.stage import Sighting, Stage
from bridge.body.cameras import cameras
from bridge.messages.world import ThingKind
from bridge.types import Array, Vec3

PERIOD: Final = 100
"""ms between two looks (assumed)."""
SPEED: Final = 0.3
"""Fraction of the head's largest speed (assumed)."""
_WALK_EVERY: Final = 400
"""ms between two orders to the walker."""
_FASTEST: Final = (0.10, 0.4)
"""m/s ahead and rad/s of a walk to a target (assumed)."""
_GAIN: Final = 0.5
"""1/s from distance and angle to the walk's velocity (assumed)."""
Walk = Callable[[float, float, float], Future[Any]]


@dataclass(frozen=True)
class FollowedTarget:
    """What is followed."""

    name: str
    """ALTracker's, for example `RedBall`; or an event's."""
    kind: ThingKind | None
    """None: not seen, but told by the event."""
    size: float
    """Diameter, m."""
    marks: tuple[str, ...] = ()
    """Numbers of the landmarks that count; empty: all."""


class Following:
    """Follows one target; not thread-safe, the caller locks.

    Args:
        stage: has the things to be seen.
        frames: of the robot.
        motion: turns its head.
        events: told that a target is lost or reached.
        neck: height of the head's joints in the Torso frame, m.
        walk: walks at a velocity; None: nobody can.
    """

    def __init__(
        self,
        stage: Stage,
        frames: RobotFrames,
        motion: JointMotion,
        events: Events,
        neck: float,
        walk: Walk | None,
    ) -> None:
        self._stage, self._frames, self._motion, self._events = stage, frames, motion, events
        self._neck, self._walk = neck, walk
        self._cameras = [camera.name for camera in cameras(frames.body)]
        self.target: FollowedTarget | None = None
        self.walks, self.time_out = False, 2000
        """Whether the robot walks to the target; and ms after which it is lost."""
        self.relative: Sequence[float] = (0.0,) * 6
        """Where the target is to be reached, x, y (m) and angle (rad) of the robot from it, and how nearly."""
        self._place: Array | None = None
        """FRAME_WORLD, (4,)."""
        self.arms: Sequence[str] = ()
        """Arms that point at it."""
        self._told: list[list[Any]] = []
        """What the event told before."""
        self._due = self._seen = self._ordered = 0
        self._lost, self._reached, self._walking = True, False, False
        for event in ("TargetLost", "TargetReached", "TargetDetected", "ActiveTargetChanged"):
            events.declare(f"ALTracker/{event}", "ALTracker")

    @property
    def lost(self) -> bool:
        """Whether the target is not seen."""
        return self.target is None or self._lost

    def begin(self, target: FollowedTarget) -> None:
        """Follow this one from now on."""
        self.end()
        self.target, self._place, self._due = target, None, 0
        self._lost, self._reached, self._seen = True, False, -1
        self._told = self._events.history(target.name)
        self._events.raise_event("ALTracker/ActiveTargetChanged", target.name)

    def end(self) -> None:
        """Follow nothing; a walk to a target ends."""
        if self.target is not None:
            self._events.raise_event("ALTracker/ActiveTargetChanged", "")
        self.target = None
        self._order((0.0, 0.0, 0.0))

    def position(self, space: Any) -> list[float]:
        """Where the target was seen last, in a space, m; empty: never."""
        if self._place is None:
            return []
        links = self._frames.measured_links()
        to_torso = self._frames.space(1, links, True)
        in_space = np.linalg.inv(self._frames.space(space, links, True)) @ to_torso @ self._place
        return [float(x) for x in in_space[:3]]

    def update(self, now: int) -> None:
        """One cycle, at `now` of the robot's clock, ms."""
        if self.target is None or now < self._due:
            return
        self._due = now + PERIOD
        if self._seen < 0:
            self._seen = now
        found = self._find(self.target)
        if found is None:
            if not self._lost and now - self._seen > self.time_out:
                self._lost = True
                self._order((0.0, 0.0, 0.0))
                self._events.raise_event("ALTracker/TargetLost", self.target.name)
            return
        if self._lost:
            self._events.raise_event("ALTracker/TargetDetected", self.target.name)
        self._lost, self._seen = False, now
        self._look(found)
        if self.walks:
            self._approach(now)

    def _find(self, target: FollowedTarget) -> Array | None:
        """The target in the Torso frame, (4,), m; None: no camera sees it."""
        if target.kind is None:
            return self._tell(target.name)
        for i, name in enumerate(self._cameras):
            for sighting in self._stage.seen(target.kind, i):
                if not target.marks or sighting.name in target.marks:
                    point: Array = self._frames.in_torso(name, sighting.links) @ point_of(sighting, target.size)
                    self._place = np.linalg.inv(self._frames.space(1, sighting.links, True)) @ point
                    return point
        return None

    def _tell(self, event: str) -> Array | None:
        """What an event told since the last look, as `_find` gives it; None: nothing, or no place."""
        told, before = self._events.history(event), self._told
        self._told = told
        place = told[-1][0] if told and told != before else None
        while isinstance(place, list) and place and isinstance(place[0], list):
            place = place[0]
        if not isinstance(place, list) or len(place) < 3 or not all(map(_is_length, place[:3])):
            return None
        self._place = np.array((*place[:3], 1.0))
        point: Array = self._frames.space(1, self._frames.measured_links(), True) @ self._place
        return point

    def _look(self, point: Array) -> None:
        camera, place = self._frames.effectors[self._cameras[0]].fixed, [float(x) for x in point[:3]]
        angles = look_angles(place, self._neck, camera)
        self._motion.set_angles(["HeadYaw", "HeadPitch"], list(angles), SPEED)
        for arm in self.arms:
            pointing = pointing_angles(place, arm, self._frames.body.lengths)
            self._motion.set_angles(list(pointing), list(pointing.values()), SPEED)

    def _approach(self, now: int) -> None:
        x, y, _ = self.position(2)
        near_x, near_angle = self.relative[3] or 0.1, self.relative[5] or 0.3
        ahead, angle = x + self.relative[0], math.atan2(y, x) + self.relative[2]
        if abs(ahead) < near_x and abs(angle) < near_angle:
            self._order((0.0, 0.0, 0.0))
            if not self._reached:
                self._events.raise_event("ALTracker/TargetReached", self.target.name if self.target else "")
            self._reached = True
            return
        self._reached = False
        if now - self._ordered >= _WALK_EVERY:
            self._ordered = now
            most, turn = _FASTEST
            speed = max(-most, min(most, _GAIN * ahead)) if abs(angle) < 2.0 * near_angle else 0.0
            self._order((speed, 0.0, max(-turn, min(turn, _GAIN * angle))))

    def _order(self, velocity: Vec3) -> None:
        walking = any(velocity)
        if self._walk is not None and (walking or self._walking):
            self._walk(*velocity)
        self._walking = walking


def _is_length(x: Any) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < 1e3


def point_of(sighting: Sighting, size: float) -> Array:
    """Where a thing is, in the camera's frame, homogeneous, (4,), m.

    Args:
        sighting: Its angles and its angular size in the picture, rad.
        size: Its diameter, m.
    """
    distance = 0.5 * size / math.sin(0.5 * sighting.size)
    across, down = math.tan(sighting.alpha), math.tan(sighting.beta)
    depth = distance / math.sqrt(1.0 + across * across + down * down)
    return np.array((depth, depth * across, -depth * down, 1.0))
