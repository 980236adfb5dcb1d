"""What a walker is told to do."""

from __future__ import annotations

import math

import msgspec


class WalkOrder(msgspec.Struct, frozen=True, kw_only=True):
    """How far to walk: by steps, by time, or without end."""

    steps: int = 0
    """Steps to walk, the closing step included; 0: no bound. At least 2 when bounded."""
    duration: float = math.inf
    """s of walking after which the robot closes its feet and stands."""
    settle: float = 1.0
    """s to stand before the order counts as done."""

    @property
    def bounded(self) -> bool:
        """Whether the walk ends by itself."""
        return self.steps > 0 or math.isfinite(self.duration)
