"""Steps, falls and velocity of a robot, followed cycle by cycle."""

from __future__ import annotations

import math
from typing import Final, Literal

from bridge import rotations
from bridge.messages import Notice, TruthFrame, WalkTelemetry
from bridge.planar import Pose2D
from bridge.types import Vec3

MIN_SUPPORT_FORCE: Final = 5.0
"""N on a supporting foot."""
MAX_SWING_FORCE: Final = 1.0
"""N up to which a foot is in the air."""
MIN_SWING_TIME: Final = 0.05
"""s that a foot must be in the air for a step: shorter ones are a sole that rocks."""
WALK_END_TIME: Final = 1.0
"""s without a foot in the air after which a walk is over."""
Event = Literal["", "lifted", "step", "over"]
_DOWN_STATES: Final = ("motion", "rest")
"""States of the walker in which the robot is down, or moves there, by order."""
_GUARD_CODES: Final = ("guard-sit", "guard-active", "guard-approach", "guard-idle")


class FallWatch:
    """Distinguishes a fall from lying: it was on its feet, is down, and was not ordered down."""

    def __init__(self) -> None:
        self.state = ""
        """The walker's, by its newest telemetry."""
        self._seated = False
        """The guard has it sit down, or sitting."""
        self._up = False
        """On its feet in the last cycle."""

    def telemetry(self, message: WalkTelemetry) -> None:
        """Take in the walker's telemetry."""
        self.state = message.state

    def notice(self, message: Notice) -> None:
        """Take in the robot's notices: its guard may sit it down."""
        if message.code in _GUARD_CODES:
            self._seated = message.code == "guard-sit"

    def restart(self) -> None:
        """Restart after the robot is placed elsewhere, perhaps lying."""
        self._up = False

    def update(self, *, down: bool) -> bool:
        """One cycle: whether the robot falls in it.

        Args:
            down: it is not on its feet.
        """
        falls = down and self._up and self.state not in _DOWN_STATES and not self._seated
        self._up = not down
        return falls


SETTLING_TIME: Final = 2.0
"""s of a walk that are left out: it begins at rest."""


class HeadingMotion:
    """Sums up the way of the torso, cycle by cycle, in the heading of each cycle."""

    def __init__(self) -> None:
        self._last: TruthFrame | None = None
        self._yaw = 0.0
        """Heading of the last frame, rad."""
        self._from = math.inf
        self._x = self._y = self._turn = self._time = 0.0
        self._marked: Vec3 | None = None
        self.turned = 0.0
        """Since the first frame, rad."""

    def begin(self, time: float) -> None:
        """A walk begins at a time of the robot, s."""
        self._from = time + SETTLING_TIME
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
        ahead, aside = Pose2D(yaw=yaw + 0.5 * turn).local(x, y)
        self._x += ahead
        self._y += aside
        self._turn += turn
        self._time += truth.time - before.time

    @property
    def velocity(self) -> Vec3:
        """Mean, forward and to the left, m/s, and turn, rad/s; zeros without samples."""
        return self._mean() if self._marked is None else self._marked

    def _mean(self) -> Vec3:
        if self._time <= 0.0:
            return 0.0, 0.0, 0.0
        return self._x / self._time, self._y / self._time, self._turn / self._time


class StepCounter:
    """Counts steps: a foot leaves the ground while the other one supports, and lands."""

    def __init__(self) -> None:
        self._lifted: dict[str, float] = {}
        self._last: float | None = None
        """Time of the last step of the present walk, or of its first lift; s."""

    def update(self, truth: TruthFrame) -> Event:
        """One cycle.

        Returns:
            `lifted`: a walk began; `step`: a foot landed; `over`: the walk ended with the last step.
        """
        if truth.fell:
            self._lifted.clear()
            return self._end()
        for foot, other in (("left", "right"), ("right", "left")):
            here, there = getattr(truth, foot).force[2], getattr(truth, other).force[2]
            if here < MAX_SWING_FORCE and there > MIN_SUPPORT_FORCE:
                self._lifted.setdefault(foot, truth.time)
                if self._last is None and truth.time - self._lifted[foot] >= MIN_SWING_TIME:
                    self._last = truth.time
                    return "lifted"
            elif here > MIN_SUPPORT_FORCE and truth.time - self._lifted.pop(foot, truth.time) >= MIN_SWING_TIME:
                self._last = truth.time
                return "step"
            elif there < MAX_SWING_FORCE:
                self._lifted.pop(foot, None)  # the robot was lifted off the ground
        if self._last is not None and not self._lifted and truth.time - self._last > WALK_END_TIME:
            return self._end()
        return ""

    def _end(self) -> Event:
        began, self._last = self._last, None
        return "" if began is None else "over"
