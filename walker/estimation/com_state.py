"""Position and velocity of the centre of mass, and the capture point that follows from them."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from bridge.types import Array
from walker.functions import LinearPendulum

SMOOTHING: Final = 0.05
"""Time constant of the velocity, s: a difference of cycles is mostly the encoders' steps."""


class ComState(NamedTuple):
    """Centre of mass in the world."""

    position: Array
    """Shape (3,), m."""
    velocity: Array
    """Shape (3,), m/s."""

    def capture_point(self, height: float) -> tuple[float, float]:
        """Where a foot would have to stand for the robot to come to rest over it, x and y in the world, m.

        Args:
            height: of the centre of mass above the ground, m.
        """
        pendulum, (x, y), (vx, vy) = LinearPendulum(height), self.position[:2], self.velocity[:2]
        return float(pendulum.capture_point(x, vx)), float(pendulum.capture_point(y, vy))


class ComEstimator:
    """Adds the velocity to positions of the centre of mass: their smoothed difference."""

    def __init__(self) -> None:
        self._last: tuple[float, Array] | None = None
        self._velocity: Array = np.zeros(3)

    def update(self, time: float, position: Array) -> ComState:
        """One position.

        Args:
            time: of the robot, s; one that is not later than the last leaves the velocity as it is.
            position: in the world, shape (3,), m.
        """
        if self._last is not None and time > self._last[0]:
            dt = time - self._last[0]
            raw = (position - self._last[1]) / dt
            self._velocity = self._velocity + min(dt / SMOOTHING, 1.0) * (raw - self._velocity)
        self._last = (time, position)
        return ComState(position, self._velocity)
