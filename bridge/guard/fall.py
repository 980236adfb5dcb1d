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

    A robot that sits, or is on its way up from the floor, leans as far and does not fall.

    Args:
        body: data sheet.
        settings: the bounds.
        stance: when it stands.
    """

    def __init__(self, body: Body, settings: FallSettings, stance: StanceSettings) -> None:
        self._body, self._s, self._stance = body, settings, stance
        self._tilted = 0
        self._may_fall = False

    def update(self, frame: SensorFrame) -> bool:
        """One cycle; True in the one in which a fall is detected."""
        angle = tilt(frame)
        if not self._may_fall and angle < self._s.upright:
            self._may_fall = stands(self._body, frame, self._stance)
        self._tilted = self._tilted + 1 if angle > self._s.angle else 0
        falls = self._s.enabled and self._may_fall and self._tilted >= self._s.cycles
        self._may_fall = self._may_fall and not falls
        return falls
