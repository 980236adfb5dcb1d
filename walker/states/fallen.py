"""Fallen, or falling: give way."""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame
from walker.estimation import Corrections, Estimate
from walker.states.state import State, StateName


class Fallen:
    """Holds the pose in which the fall was noticed, limply, so that gears and limbs yield to the ground.

    Args:
        position: measured joint angles, 25 slots, rad.
        stiffness: to hold them with, 0..1.
    """

    name: Final[StateName] = "fallen"
    corrections: Final = Corrections()

    def __init__(self, position: tuple[float, ...], stiffness: float) -> None:
        self.position = position
        self.stiffness = stiffness
        self.settled = 0.0

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> State:
        """Lie still: nobody gets up by himself here."""
        self.settled += dt
        return self
