"""The end of a walk, or what comes before one is ordered: stand."""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame
from walker.estimation import Corrections, Estimate
from walker.stabilization.stabilizer import Stabilizer
from walker.states.state import StateName


class Standing:
    """Holds the last angles of the walk, corrections included: both feet are on the ground they found.

    Args:
        position: joint angles, 25 slots, rad.
        stabilizer: of the last walk and the next; its filters go on.
        corrections: in `position`.
    """

    name: Final[StateName] = "stand"

    def __init__(self, position: tuple[float, ...], stabilizer: Stabilizer, corrections: Corrections) -> None:
        self.position = position
        self.stiffness = 1.0
        self.settled = 0.0
        self.corrections = corrections._replace(common=(0.0, 0.0))
        self._stabilizer = stabilizer

    def settle(self, estimate: Estimate) -> None:
        """One cycle before the robot stands; see `Stabilizer.settle`."""
        self._stabilizer.settle(estimate)

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """Stand on."""
        self.settled += dt
        self._stabilizer.settle(estimate)
