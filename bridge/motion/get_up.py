"""Getting up: the motion for the side on which the robot lies, repeated until the robot stands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Final

import numpy as np

from bridge.body import Body
from bridge.body.joints import LEG_SLOTS, N_JOINTS
from bridge.messages import SensorFrame
from bridge.motion.keyframes import Lying, Motion, load_motion, mirrored, motion_names
from bridge.motion.player import MotionPlayer, lying
from bridge.stance import stands
from bridge.types import Array

GET_UP: Final = "get-up"
"""In place of a motion's name: the one for the lying side, repeated until the robot stands."""
MAX_TRIES: Final = 5
"""Tries, after which the robot keeps lying."""
LIMP_STIFFNESS: Final = 0.1
"""Stiffness between two tries."""
TRY_STIFFNESS: Final = 0.5
"""Stiffness commanded before a try; the robot has it once its guard takes commands."""
_MAX_QUIET_RATE: Final = 0.3
"""rad/s; a torso that turns more slowly in all axes lies still."""
_QUIET_TIME: Final = 0.1
"""s for which it has to lie still."""
_MAX_WAIT: Final = 2.0
"""s after which a try begins however the torso moves."""
_MAX_UPRIGHT_TILT: Final = 0.35
"""rad from the vertical; a torso that leans by more rests on more than the feet."""
_BLOCKED_ERROR: Final = 0.5
"""rad by which a blocked joint of an arm is behind its angle."""
_BLOCKED_TIME: Final = 1.0
"""s for which it has to be behind; 0.54 s at most in successful tries, up to 4.3 s in others. Legs that hook
into each other release in the course of a motion."""


def get_up_motions(body: Body) -> dict[Lying, Motion]:
    """The package's motions that get this body up, by the side on which it lies; {}: none."""
    motions: dict[Lying, Motion] = {}
    for motion in _shipped():
        if motion.gets_up and body.base in motion.bodies:
            motions |= dict.fromkeys(motion.begins, motion)
    if "left" in motions:
        motions.setdefault("right", mirrored(motions["left"]))
    return motions


@cache
def _shipped() -> tuple[Motion, ...]:
    """Read once per process: every controller asks."""
    return tuple(map(load_motion, motion_names()))


class GetUp:
    """Waits until the torso lies still, plays the motion for its side, and checks whether the robot stands.

    A try begins when the joints are stiff: after a fall the guard takes no command for a while. It ends when
    the guard releases the joints or an arm is blocked. A joint ends one try at most: its motor may be broken.

    Args:
        motions: by the side on which the robot lies.
        body: whose joints.
        tries: at most.
    """

    def __init__(self, motions: Mapping[Lying, Motion], body: Body, tries: int = MAX_TRIES) -> None:
        self._motions, self._body, self._max_tries = motions, body, tries
        self._player: MotionPlayer | None = None
        self.position: tuple[float, ...] = (0.0,) * N_JOINTS
        """Angles of the last cycle, 25 in frame order, rad."""
        self._quiet = self._waited = 0.0
        self._behind: Array = np.zeros(N_JOINTS)
        self._watched = np.ones(N_JOINTS, dtype=np.bool_)
        for slots in LEG_SLOTS.values():
            self._watched[list(slots)] = False
        self.began: list[Lying] = []
        """Lying side at the beginning of each try."""
        self.stiffness = LIMP_STIFFNESS
        """Targets of all joints now."""
        self.done = False
        """The robot stands, or the tries are used up."""
        self.failed = False
        """The tries are used up."""

    def advance(self, frame: SensorFrame, dt: float) -> tuple[float, ...]:
        """Joint angles of this cycle, 25 in frame order, rad.

        Args:
            frame: newest sensor frame.
            dt: time since the last one, s.
        """
        if self._player is not None and (self._player.done or _limp(frame) or self._blocked(frame, dt)):
            self.done = self._player.done and not self._player.failed and self._stands(frame)
            self._player = None
        if self._player is None and not self.done and self._lies_still(frame, dt):
            self.position, self.stiffness = frame.position, TRY_STIFFNESS
            if not _limp(frame):
                self._begin_try(frame)
        if self._player is not None:
            self.position = self._player.advance(frame, dt)
            self.stiffness = self._player.stiffness
        return self.position

    def _blocked(self, frame: SensorFrame, dt: float) -> bool:
        behind = np.abs(np.subtract(self.position, frame.position)) > _BLOCKED_ERROR
        self._behind = np.where(behind & self._watched, self._behind + dt, 0.0)
        blocked = self._behind > _BLOCKED_TIME
        self._watched &= ~blocked
        return bool(blocked.any())

    def _lies_still(self, frame: SensorFrame, dt: float) -> bool:
        if self._waited == 0.0:
            self.position, self.stiffness = frame.position, LIMP_STIFFNESS
        self._waited += dt
        self._quiet = self._quiet + dt if np.abs(frame.gyroscope).max() < _MAX_QUIET_RATE else 0.0
        return self._quiet >= _QUIET_TIME or self._waited >= _MAX_WAIT

    def _begin_try(self, frame: SensorFrame) -> None:
        self._quiet = self._waited = 0.0
        if self._stands(frame):
            self.done = True
            return
        lying_side = lying(frame.angle)
        motion = self._motions.get(lying_side)
        if motion is None or len(self.began) >= self._max_tries:
            self.done = self.failed = True
            return
        self.began.append(lying_side)
        self._behind[:] = 0.0
        self._player = MotionPlayer(motion, self._body)

    def _stands(self, frame: SensorFrame) -> bool:
        return math.hypot(*frame.angle) < _MAX_UPRIGHT_TILT and stands(self._body, frame)


def _limp(frame: SensorFrame) -> bool:
    """Whether the legs have no stiffness."""
    return max(frame.stiffness[slot] for slots in LEG_SLOTS.values() for slot in slots) < 2.0 * LIMP_STIFFNESS
