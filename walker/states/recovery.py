"""Getting up: when a robot that lies or rests plays its get-up motions."""

from __future__ import annotations

from typing import Final

from bridge.body import Body
from bridge.messages import SensorFrame
from bridge.motion import GetUp, Lying, get_up_motions
from bridge.stance import stands
from walker.states.fallen import Fallen
from walker.states.motion import Moving
from walker.states.rest import Resting
from walker.states.state import State

REST: Final = 2.0
"""s that a robot lies before it gets up: longer than its guard takes no command after a fall."""


class Recovery:
    """Decides when a robot gets up, and counts it.

    Args:
        body: Data sheet; its motions get it up.
        after_falls: Get up after a fall. A robot that sits, or rests, gets up in any case.
    """

    def __init__(self, body: Body, *, after_falls: bool) -> None:
        self.body = body
        """Data sheet."""
        self._motions = get_up_motions(body)
        self.after_falls = after_falls and bool(self._motions)
        """A robot that falls gets up again."""
        self.count = 0
        """How often the robot got up from lying."""

    def begins_down(self, frame: SensorFrame, lying_side: Lying) -> bool:
        """Whether the robot of the first frame is to get up before anything else."""
        may = self.after_falls or lying_side == "upright"
        return may and lying_side in self._motions and not stands(self.body, frame)

    def pending(self, state: State) -> bool:
        """Whether a robot that fell is yet to try to get up."""
        return self.after_falls and isinstance(state, Fallen) and not state.gave_up

    def due(self, state: State, *, ordered: bool) -> bool:
        """Whether the robot gets up now.

        Args:
            state: Of the controller.
            ordered: A walk waits for the robot.
        """
        return (isinstance(state, Resting) and ordered) or (self.pending(state) and state.settled >= REST)

    def get_up(self, frame: SensorFrame, *, from_lying: bool) -> Moving:
        """The state in which the robot gets up."""
        return Moving(GetUp(self._motions, self.body), frame.position, from_lying=from_lying)

    def note_end(self, state: State) -> None:
        """Count a get-up that has put a lying robot on its feet."""
        self.count += isinstance(state, Moving) and state.got_up and state.from_lying
