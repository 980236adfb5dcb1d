"""Getting up: when a robot that lies or rests plays its get-up motions, and what its walk does afterwards."""

from __future__ import annotations

import math
from typing import Final, Literal

from bridge.body import Body
from bridge.body.joints import LEG_SLOTS
from bridge.messages import SensorFrame
from bridge.motion import GetUp, Lying, get_up_motions
from bridge.stance import stands
from walker.states.fallen import Fallen
from walker.states.motion import Moving
from walker.states.rest import Resting
from walker.states.state import State

REST: Final = 2.0
"""s that a robot lies before it gets up: longer than its guard takes no command after a fall."""
MotionEnd = Literal["on its feet", "stands", "rests", "lies"]
"""What came of a motion: got up; stands, after another motion; rests where it ended; getting up failed."""


class Recovery:
    """Remembers a fall until the robot stands again.

    Args:
        body: Data sheet; its motions get it up.
        after_falls: Get up after a fall. A robot that sits, or rests, gets up in any case.
    """

    def __init__(self, body: Body, *, after_falls: bool) -> None:
        self._body, self._motions = body, get_up_motions(body)
        self.after_falls = after_falls and bool(self._motions)
        """A robot that falls gets up again."""
        self.resume = False
        """The robot walked when it fell: its order goes on once it stands."""
        self.count = 0
        """How often the robot got up from lying."""
        self._gave_up = False
        self._lay = False
        """The robot that gets up lay."""
        self._went_limp = False
        """Since it fell or a motion ended."""

    def begins_down(self, frame: SensorFrame, below: Lying) -> bool:
        """Whether the robot of the first frame is to get up before anything else."""
        may = self.after_falls or below == "upright"
        return may and below in self._motions and not stands(self._body, frame)

    def fell(self, *, walked: bool) -> None:
        """The robot begins to fall, out of a walk or not."""
        self._gave_up = self._went_limp = False
        self.resume = walked

    def pending(self, state: State) -> bool:
        """Whether a robot that fell is yet to try to get up."""
        return self.after_falls and isinstance(state, Fallen) and not self._gave_up

    def due(self, state: State, *, ordered: bool) -> bool:
        """Whether the robot gets up now.

        Args:
            state: Of the controller.
            ordered: A walk waits for the robot.
        """
        return (isinstance(state, Resting) and ordered) or (self.pending(state) and state.settled >= REST)

    def get_up(self, state: State, frame: SensorFrame, below: Lying) -> Moving:
        """The state in which the robot gets up, from another one."""
        self._lay = isinstance(state, Fallen) or below != "upright"
        return Moving(GetUp(self._motions, self._body), frame.position)

    def end(self, motion: Moving, frame: SensorFrame) -> MotionEnd:
        """Judge a motion that is done."""
        player, self._went_limp = motion.player, False
        gets_up = isinstance(player, GetUp)
        self._gave_up = gets_up and player.failed
        if self._gave_up:
            return "lies"
        if gets_up:
            self.count += self._lay
            return "on its feet"
        return "stands" if motion.stiffness == 1.0 and stands(self._body, frame) else "rests"

    def put_up(self, state: State, frame: SensorFrame, angle: float) -> bool:
        """Whether somebody put the robot that fell on its feet: it was limp, now it is stiff.

        Args:
            state: Of the controller.
            frame: Its fused angle counts; the walker's own still turns up from where the robot lay.
            angle: Of the torso, beyond which the robot is falling, rad.
        """
        if not isinstance(state, Fallen | Resting):
            return False
        legs = min(frame.stiffness[slot] for slots in LEG_SLOTS.values() for slot in slots)
        stiff = legs > 2.0 * state.stiffness
        self._went_limp = self._went_limp or not stiff
        return self._went_limp and stiff and math.hypot(*frame.angle) < angle
