"""What every state of the walk is."""

from __future__ import annotations

from typing import Literal, Protocol

from bridge.messages import SensorFrame
from walker.estimation import Corrections, Estimate

StateName = Literal["approach", "walk", "stopping", "stand", "fallen", "motion", "rest"]


class State(Protocol):
    """Answers sensor frames until another state takes over."""

    @property
    def name(self) -> StateName:
        """For telemetry."""
        ...

    @property
    def settled(self) -> float:
        """Time for which the robot has done nothing more in a final state, s; 0 in the others."""
        ...

    @property
    def position(self) -> tuple[float, ...]:
        """Joint angles asked for in this cycle, 25 slots, rad."""
        ...

    @property
    def stiffness(self) -> float:
        """Stiffness asked for of all joints in this cycle."""
        ...

    @property
    def corrections(self) -> Corrections:
        """What of `position` is not the plan's."""
        ...

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> State:
        """One cycle.

        Args:
            frame: newest sensor frame.
            estimate: what it tells.
            dt: time since the last one, s.

        Returns:
            The state whose answer is in force now: this one, or its successor.
        """
        ...
