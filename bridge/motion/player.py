"""Plays a key-frame motion: sensor frames in, joint angles out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from bridge.body import Body
from bridge.body.joints import INDEX, N_JOINTS
from bridge.messages import SensorFrame
from bridge.motion.keyframes import Gate, KeyFrameTarget, Lying, Motion, targets

_GYROSCOPE_WEIGHT: Final = 0.3
"""Weight of the newest gyroscope sample in a cycle (Dutch Nao Team's)."""
_MIN_UPRIGHT_COSINE: Final = math.cos(math.radians(45.0))
SETTLE_TIME: Final = 0.3
"""s at the last frame before the end of the motion."""


def lying(angle: tuple[float, float]) -> Lying:
    """Side on which the robot lies, by the fused angle.

    Args:
        angle: torso roll and pitch, rad.
    """
    roll, pitch = angle
    # the direction of the sky in the torso
    x, y, z = -math.sin(pitch), math.cos(pitch) * math.sin(roll), math.cos(pitch) * math.cos(roll)
    if z > _MIN_UPRIGHT_COSINE:
        return "upright"
    if abs(x) >= abs(y):
        return "back" if x > 0.0 else "front"
    return "right" if y > 0.0 else "left"


class MotionPlayer:
    """Joint angles of a motion, cycle by cycle.

    Args:
        motion: to play.
        body: whose joints.
        present: the robot's targets at the beginning, 25 in frame order, rad, where joints stay that have not
            been named; None: the measured angles, as of a robot that was limp.
    """

    def __init__(self, motion: Motion, body: Body, present: Sequence[float] | None = None) -> None:
        self._motion, self._present = motion, present
        self._targets = targets(motion, body)
        self._from: tuple[float, ...] | None = None
        self._number = 0
        self._time = self._waited = 0.0
        self._gyroscope = 0.0
        self.done = False
        """The motion is over."""
        self.failed = False
        """The torso is outside a gate; the motion is over."""
        self.stiffness = self._targets[0].stiffness
        """Targets of all joints now."""
        self.position: tuple[float, ...] = tuple(present or (0.0,) * N_JOINTS)
        """Angles of the last cycle, 25 in frame order, rad."""

    def advance(self, frame: SensorFrame, dt: float) -> tuple[float, ...]:
        """Joint angles of this cycle, 25 in frame order, rad.

        Args:
            frame: newest sensor frame.
            dt: time since the last one, s.
        """
        self._gyroscope += _GYROSCOPE_WEIGHT * (frame.gyroscope[1] - self._gyroscope)
        if self._from is None:
            self._from, dt = frame.position, 0.0
            self._present = self._present or frame.position
        self._time += dt
        duration = self._duration()
        if self._time >= duration and not self.done:
            self._end_frame(frame, dt, duration)
            duration = self._duration()
        target = self._targets[self._number]
        self.stiffness = target.stiffness
        share = min(self._time / duration, 1.0) if duration > 0.0 else 1.0
        position = [a + share * (b - a) for a, b in zip(self._from, self._pose(target), strict=True)]
        for joint in ("LAnklePitch", "RAnklePitch"):
            position[INDEX[joint]] += self._motion.ankle_gyroscope * self._gyroscope
        for joint in ("LHipPitch", "RHipPitch"):
            position[INDEX[joint]] += self._motion.hip_gyroscope * self._gyroscope
        self.position = tuple(position)
        return self.position

    def _pose(self, target: KeyFrameTarget) -> tuple[float, ...]:
        """All angles of a frame, 25 in frame order, rad."""
        assert self._present is not None
        return tuple(target.position.get(i, angle) for i, angle in enumerate(self._present))

    def _duration(self) -> float:
        """Duration of the way to the present frame, s; the approach speed bounds that to the first one."""
        assert self._from is not None
        target: KeyFrameTarget = self._targets[self._number]
        if self._number > 0:
            return target.duration
        way = max(abs(b - a) for a, b in zip(self._from, self._pose(target), strict=True))
        return max(target.duration, way / self._motion.approach_speed)

    def _end_frame(self, frame: SensorFrame, dt: float, duration: float) -> None:
        """Begin the next frame, wait at a gate, or end."""
        target = self._targets[self._number]
        if target.gate is not None and not _open(target.gate, frame):
            self._waited += dt
            self.failed = self._waited > target.gate.wait
            self.done = self.failed
            return
        self._waited = 0.0
        if self._number + 1 < len(self._targets):
            self._from, self._time = self._pose(target), self._time - duration
            self._number += 1
        else:
            self.done = self._time >= duration + SETTLE_TIME


def _open(gate: Gate, frame: SensorFrame) -> bool:
    roll, pitch = frame.angle
    return gate.pitch[0] <= pitch <= gate.pitch[1] and gate.roll[0] <= roll <= gate.roll[1]
