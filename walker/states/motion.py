"""A key-frame motion under way: getting up, or one that was ordered."""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame
from bridge.motion import GetUp, MotionPlayer
from walker.estimation import Corrections, Estimate
from walker.states.state import StateName


class Moving:
    """Plays a motion.

    Args:
        player: at the beginning of its motion.
        position: joint angles until the first cycle, 25 slots, rad.
        from_lying: the robot lies as it begins.
    """

    name: Final[StateName] = "motion"
    settled: Final = 0.0
    corrections: Final = Corrections()

    def __init__(self, player: MotionPlayer | GetUp, position: tuple[float, ...], *, from_lying: bool) -> None:
        self.player = player
        self.position = position
        self.stiffness = player.stiffness
        self.from_lying = from_lying
        """The robot lay as the motion began."""

    @property
    def got_up(self) -> bool:
        """The get-up is done, and the robot on its feet."""
        return isinstance(self.player, GetUp) and self.player.done and not self.player.failed

    @property
    def failed(self) -> bool:
        """The get-up is done, and the robot lies."""
        return isinstance(self.player, GetUp) and self.player.done and self.player.failed

    def advance(self, frame: SensorFrame, estimate: Estimate, dt: float) -> None:
        """One cycle."""
        self.position = self.player.advance(frame, dt)
        self.stiffness = self.player.stiffness
