"""The end of a walk, or what comes before one is ordered: stand."""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame
from walker.estimation import Estimate
from walker.stabiliser import Stabiliser
from walker.states.state import State, StateName


class Standing:
    """Holds the last angles of the walk, corrections included: both feet are on the ground they found.

    Args:
        position: joint angles, 25 slots, rad.
        stabiliser: of the last walk and the next; its filters go on.
    """

    name: Final[StateName] = "stand"

    def __init__(self, position: tuple[float, ...], stabiliser: Stabiliser) -> None:
        self.position = position
        self.stiffness = 1.0
        self.settled = 0.0
        self._stabiliser = stabiliser

    def watch(self, estimate: Estimate) -> None:
        """Take in a cycle before the robot stands."""
        self._stabiliser.watch(estimate)

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> State:
        """Stand on."""
        self.settled += dt
        self._stabiliser.watch(estimate)
        return self
