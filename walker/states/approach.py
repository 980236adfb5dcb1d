"""The beginning: from wherever the joints are into the gait's stand."""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame
from walker.approach import Approach
from walker.estimation import Estimate
from walker.states.state import State, StateName
from walker.states.walk import Walking


class Approaching:
    """Moves all joints slowly to where the walk begins.

    Args:
        goal: joint angles to reach, 25 slots, rad.
        walking: the state that follows.
    """

    name: Final[StateName] = "approach"
    settled: Final = 0.0

    def __init__(self, goal: tuple[float, ...], walking: Walking) -> None:
        self._goal = goal
        self._walking = walking
        self._approach: Approach | None = None
        self.position = goal
        self.stiffness = 1.0

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> State:
        """One cycle; the motion begins at the first frame's angles."""
        if self._approach is None:
            self._approach = Approach(frame.position, self._goal)
        elif self._approach.done:
            return self._walking.advance(frame, estimate, dt)
        self.position = self._approach.advance(dt)
        self._walking.watch(estimate)
        return self
