"""Down by order: sits, crouches or lies as a motion left it."""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame
from walker.estimation import Corrections, Estimate
from walker.states.state import StateName, legs_hold

STIFFNESS: Final = 0.1
"""Of all joints. With none an emulated robot tips over in the crouch: its thighs do not rest on its calves."""


class Resting:
    """Stays where a motion ended, nearly limp, until something is ordered.

    Args:
        position: joint angles at the motion's end, 25 slots, rad.
    """

    name: Final[StateName] = "rest"
    corrections: Final = Corrections()

    def __init__(self, position: tuple[float, ...]) -> None:
        self.position = position
        self.stiffness = STIFFNESS
        self.settled = 0.0
        self.went_limp = False
        """The legs were no stiffer than asked for."""

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """Rest on."""
        self.settled += dt
        self.went_limp = self.went_limp or not legs_hold(frame, self.stiffness)
