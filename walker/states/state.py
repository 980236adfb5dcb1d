"""What every state of the walk is."""

from __future__ import annotations

from typing import Literal, Protocol

from bridge.body.joints import LEG_SLOTS
from bridge.messages import SensorFrame
from walker.estimation import Corrections, Estimate

StateName = Literal["approach", "walk", "stopping", "stand", "fallen", "motion", "rest"]


class State(Protocol):
    """Answers sensor frames; `walker.transitions` says when another state takes over."""

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

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """One cycle.

        Args:
            frame: newest sensor frame.
            estimate: what it tells.
            dt: time since the last one, s.
        """
        ...


def legs_hold(frame: SensorFrame, stiffness: float) -> bool:
    """Whether all joints of the legs are stiffer than a state that gives way has them.

    Args:
        frame: newest sensor frame.
        stiffness: that the state asks for.
    """
    return min(frame.stiffness[slot] for slots in LEG_SLOTS.values() for slot in slots) > 2.0 * stiffness
