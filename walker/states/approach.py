"""The beginning: from wherever the joints are into the gait's stand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from bridge.body.joints import LEG_SLOTS
from bridge.messages import SensorFrame
from walker.estimation import Corrections, Estimate
from walker.states.joint_interpolation import JointInterpolation
from walker.states.stand import Standing
from walker.states.state import StateName
from walker.states.walk import Walking

NEAR: Final = 0.35
"""rad from a leg joint to the stand: the vendor's StandInit is 0.26 from that of `omni`."""
LEGS: Final = (*LEG_SLOTS["L"], *LEG_SLOTS["R"])


class Approaching:
    """Moves all joints slowly to where the walk begins.

    Args:
        goal: joint angles to reach, 25 slots, rad.
        successor: the state that follows.
        begin: joint angles to ask for at first, 25 slots, rad, by the first frame.
    """

    name: Final[StateName] = "approach"
    settled: Final = 0.0
    corrections: Final = Corrections()

    def __init__(
        self,
        goal: tuple[float, ...],
        successor: Walking | Standing,
        begin: Callable[[SensorFrame], tuple[float, ...]],
    ) -> None:
        self._goal = goal
        self.successor = successor
        """The state that follows."""
        self._begin = begin
        self._approach: JointInterpolation | None = None
        self.position = goal
        self.stiffness = 1.0

    @property
    def near(self) -> bool:
        """Whether a walk may begin at once: the legs are near the goal, from where the walk blends them in."""
        if self._approach is None:
            return False
        return max(abs(self._goal[i] - self.position[i]) for i in LEGS) <= NEAR

    @property
    def to_stand(self) -> bool:
        """Whether no walk follows."""
        return isinstance(self.successor, Standing)

    @property
    def done(self) -> bool:
        """The successor's pose is reached."""
        return self._approach is not None and self._approach.done

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """One cycle."""
        if self._approach is None:
            self._approach = JointInterpolation(self._begin(frame), self._goal)
        self.position = self._approach.advance(dt)
        self.successor.settle(estimate)
