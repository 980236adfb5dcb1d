"""Detection of a fall by the fused angle."""

from __future__ import annotations

import math

from bridge.body import Body
from bridge.guard.config import FallSettings
from bridge.messages import SensorFrame
from bridge.stance import StanceSettings, stands


def tilt(frame: SensorFrame) -> float:
    """Angle between the torso and the vertical by the fused angle, rad: cos(tilt) = cos(roll) cos(pitch)."""
    roll, pitch = frame.angle
    return math.acos(max(-1.0, min(1.0, math.cos(roll) * math.cos(pitch))))


class FallMonitor:
    """Reports a fall once: after some cycles of too much tilt of a robot that stood upright before.

    A robot that sits, or is on its way up from the floor, leans as far and does not fall; on the way it may be
    upright for a moment, with a sole below its hip.

    Args:
        body: data sheet.
        settings: the bounds.
        stance: when it stands.
    """

    def __init__(self, body: Body, settings: FallSettings, stance: StanceSettings) -> None:
        self._body, self._s, self._stance = body, settings, stance
        self._tilted = self._stood = 0
        self._may_fall = False

    def update(self, frame: SensorFrame) -> bool:
        """One cycle; True in the one in which a fall is detected."""
        angle = tilt(frame)
        if not self._may_fall:
            upright = angle < self._s.upright and stands(self._body, frame, self._stance)
            self._stood = self._stood + 1 if upright else 0
            self._may_fall = self._stood >= self._s.stood_cycles
        self._tilted = self._tilted + 1 if angle > self._s.angle else 0
        falls = self._s.enabled and self._may_fall and self._tilted >= self._s.cycles
        self._may_fall = self._may_fall and not falls
        return falls
