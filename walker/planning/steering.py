"""Velocity that leads a walk to a place and to a heading."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Protocol

from bridge.types import Vec3
from walker.planning.plan import Foothold

NEAR: Final = 0.015
"""m from the place at which the walk is over."""
TURNED: Final = 0.05
"""rad from the heading, likewise."""
_BRAKING: Final = 0.7
"""Part of the gait's acceleration that is planned on: a velocity changes at the next step only."""
_LAST: Final = 0.5
"""s in which the rest of the way is planned to be walked when it is short: two steps."""


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

    def arrived(self, here: Foothold) -> bool:
        """Whether the goal is reached."""
        x, y, turn = self.to_go(here)
        return math.hypot(x, y) < NEAR and abs(turn) < TURNED

    def velocity(self, here: Foothold) -> Vec3:
        """Of the next step, m/s, m/s, rad/s.

        Args:
            here: middle between the feet, in the frame of the odometry.
        """
        way = self.to_go(here)
        time = max(self.limits.share(way) / self.share, _LAST)
        for rest, acceleration in zip(way, self.limits.max_acceleration, strict=True):
            # v^2 = 2 a s, and v = s / time
            time = max(time, math.sqrt(abs(rest) / (2.0 * _BRAKING * acceleration)))
        x, y, turn = (rest / time for rest in way)
        return x, y, turn
