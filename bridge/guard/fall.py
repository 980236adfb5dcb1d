"""Detection of a fall by the fused angle."""

from __future__ import annotations

import math

from bridge.guard.config import FallSettings
from bridge.messages import SensorFrame


def tilt(frame: SensorFrame) -> float:
    """Angle between the torso and the vertical by the fused angle, rad: cos(tilt) = cos(roll) cos(pitch)."""
    roll, pitch = frame.angle
    return math.acos(max(-1.0, min(1.0, math.cos(roll) * math.cos(pitch))))


class FallMonitor:
    """Reports a fall once: after some cycles of too much tilt, and again only after the robot was upright.

    Args:
        settings: the bounds.
    """

    def __init__(self, settings: FallSettings) -> None:
        self._s = settings
        self._tilted = 0
        self._may_fall = True

    def update(self, frame: SensorFrame) -> bool:
        """One cycle; True in the one in which a fall is detected."""
        angle = tilt(frame)
        self._may_fall = self._may_fall or angle < self._s.upright
        self._tilted = self._tilted + 1 if angle > self._s.angle else 0
        falls = self._s.enabled and self._may_fall and self._tilted >= self._s.cycles
        self._may_fall = self._may_fall and not falls
        return falls
