"""A key-frame motion under way: getting up, or one that was ordered."""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame
from bridge.motion import GetUp, MotionPlayer
from walker.estimation import Corrections, Estimate
from walker.states.state import State, StateName


class Moving:
    """Plays a motion; who began it looks whether it is done, and what comes then.

    Args:
        player: at the beginning of its motion.
        position: joint angles until the first cycle, 25 slots, rad.
    """

    name: Final[StateName] = "motion"
    settled: Final = 0.0
    corrections: Final = Corrections()

    def __init__(self, player: MotionPlayer | GetUp, position: tuple[float, ...]) -> None:
        self.player = player
        self.position = position
        self.stiffness = player.stiffness

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> State:
        """One cycle."""
        self.position = self.player.advance(frame, dt)
        self.stiffness = self.player.stiffness
        return self
