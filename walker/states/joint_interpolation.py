"""From wherever the joints are to where a gait begins, slowly."""

from __future__ import annotations

from typing import Final

from bridge.body.joints import N_JOINTS
from walker.functions import quintic

SPEED: Final = 0.6
"""rad/s; the fastest joint's mean speed (assumed safe: a sixth of the slowest leg joint's no-load speed)."""
SHORTEST: Final = 1.0
"""s"""


class JointInterpolation:
    """Rest-to-rest motion in joint space.

    Args:
        start: measured angles, 25 slots, rad.
        goal: angles to reach, 25 slots, rad.
    """

    def __init__(self, start: tuple[float, ...], goal: tuple[float, ...]) -> None:
        self._start, self._goal = start, goal
        way = max(abs(goal[i] - start[i]) for i in range(N_JOINTS))
        self._duration = max(SHORTEST, way / SPEED)
        self._t = 0.0

    @property
    def done(self) -> bool:
        """The goal has been commanded, and half a second given to settle there."""
        return self._t >= self._duration + 0.5

    def advance(self, dt: float) -> tuple[float, ...]:
        """Angles `dt` seconds later, 25 slots, rad."""
        self._t += dt
        return tuple(
            quintic(a, b, self._duration, self._t).position
            for a, b in zip(self._start, self._goal, strict=True)
        )
