"""Velocity that leads a walk to a place and to a heading."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Protocol

from bridge.types import Vec3
from walker.planning.plan import Foothold

NEAR: Final = 0.008
"""m from the place at which the walk is over."""
TURNED: Final = 0.03
"""rad from the heading, likewise."""
_CLOSE: Final = 4.0
"""Error, as `_error` counts it, below which a walk is over if another step leads no closer."""
_CLOSER: Final = 0.2
"""What such a step takes off the error at least."""
_BRAKING: Final = 0.7
"""Part of the gait's acceleration that is planned on: a velocity changes at the next step only."""
_LAST: Final[Vec3] = (0.25, 0.5, 0.5)
"""s in which the rest of the way is planned to be walked when it is short: a step; sideways and turning, where
the foot on the outer side follows, two."""


class Limits(Protocol):
    """Of a gait that walks in any direction."""

    @property
    def max_velocity(self) -> Vec3:
        """Forward, to either side, m/s, and turn, rad/s."""
        ...

    @property
    def max_acceleration(self) -> Vec3:
        """Fastest gain of velocity, m/s^2, m/s^2, rad/s^2."""
        ...

    def share(self, velocity: Vec3) -> float:
        """Part of the limits that a velocity takes up, over 1 outside of them."""
        ...


@dataclass(frozen=True)
class Steering:
    """Leads to a goal.

    Straight, while the heading turns at a steady rate; slowed down in time to stop there.
    """

    limits: Limits
    goal: Foothold
    """Middle between the feet at the end, in the frame of the odometry."""
    share: float = 1.0
    """Of the limits that is made use of."""

    def to_go(self, here: Foothold) -> Vec3:
        """Way and turn that remain, in the frame of `here`, m, m, rad."""
        x, y = here.local(self.goal.x, self.goal.y)
        return x, y, math.remainder(self.goal.yaw - here.yaw, math.tau)

    def arrived(self, now: Foothold, later: Foothold) -> bool:
        """Whether the walk is over: at the goal, or close to it while another step leads no closer.

        Feedback can move the footholds of a slow walk by more than its velocity corrects.

        Args:
            now: where the feet would come to rest after this step, in the frame of the odometry.
            later: the same after one more step on the spot.
        """
        step = _LAST[0]
        rest = (way - step * v for way, v in zip(self.to_go(later), self.velocity(later), strict=True))
        error = _error(self.to_go(now))
        return error < 1.0 or (error < _CLOSE and error < _error(tuple(rest)) + _CLOSER)

    def velocity(self, here: Foothold) -> Vec3:
        """Of the next step, m/s, m/s, rad/s.

        Args:
            here: middle between the feet, in the frame of the odometry.
        """
        way = self.to_go(here)
        time = self.limits.share(way) / self.share
        for rest, acceleration in zip(way, self.limits.max_acceleration, strict=True):
            # v^2 = 2 a s, and v = s / time
            time = max(time, math.sqrt(abs(rest) / (2.0 * _BRAKING * acceleration)))
        x, y, turn = (rest / max(time, last) for rest, last in zip(way, _LAST, strict=True))
        return x, y, turn


def _error(way: tuple[float, ...]) -> float:
    """Of a way and turn that remain, m, m, rad; 1 where the walk is over."""
    x, y, turn = way
    return max(math.hypot(x, y) / NEAR, abs(turn) / TURNED)
