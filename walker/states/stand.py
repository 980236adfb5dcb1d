"""The end of a walk: stand."""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame
from walker.estimation import Estimate
from walker.states.state import State, StateName


class Standing:
    """Holds the last angles of the walk, corrections included: both feet are on the ground they found.

    Args:
        position: joint angles, 25 slots, rad.
    """

    name: Final[StateName] = "stand"

    def __init__(self, position: tuple[float, ...]) -> None:
        self.position = position
        self.stiffness = 1.0
        self.settled = 0.0

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> State:
        """Stand on."""
        self.settled += dt
        return self
