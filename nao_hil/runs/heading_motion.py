"""Velocity of the torso in its own heading, from the ground truth."""

from __future__ import annotations

import math
from typing import Final

from bridge import rotations
from bridge.messages import TruthFrame
from bridge.types import Vec3

SETTLING: Final = 2.0
"""s of a walk that are left out: it begins at rest."""


class HeadingMotion:
    """Sums up the way of the torso, cycle by cycle, in the heading of each cycle."""

    def __init__(self) -> None:
        self._last: TruthFrame | None = None
        self._yaw = 0.0
        """Of the last frame, rad."""
        self._from = math.inf
        self._x = self._y = self._turn = self._time = 0.0
        self._marked: Vec3 | None = None
        self.turned = 0.0
        """Since the first frame, rad."""

    def begin(self, time: float) -> None:
        """A walk begins at a time of the robot, s."""
        self._from = time + SETTLING
        self._x = self._y = self._turn = self._time = 0.0
        self._marked = None

    def end(self) -> None:
        """The walk is over."""
        self._from = math.inf

    def mark(self) -> None:
        """The walk may turn out to have ended here: until the next mark the velocity is that of now."""
        self._marked = self._mean()

    def add(self, truth: TruthFrame) -> None:
        """The next boundary of the cycle."""
        before, self._last = self._last, truth
        yaw, self._yaw = self._yaw, float(rotations.yaw(truth.torso_orientation))
        if before is None:
            return
        turn = math.remainder(self._yaw - yaw, math.tau)
        self.turned += turn
        if before.time < self._from:
            return
        x, y = (b - a for a, b in zip(before.torso_position[:2], truth.torso_position[:2], strict=True))
        ahead, aside = rotations.planar_point((0.0, 0.0, -(yaw + 0.5 * turn)), (x, y))
        self._x += ahead
        self._y += aside
        self._turn += turn
        self._time += truth.time - before.time

    @property
    def velocity(self) -> Vec3:
        """Mean, forward and to the left, m/s, and turn, rad/s; zeros where nothing was summed up."""
        return self._mean() if self._marked is None else self._marked

    def _mean(self) -> Vec3:
        if self._time <= 0.0:
            return 0.0, 0.0, 0.0
        return self._x / self._time, self._y / self._time, self._turn / self._time
