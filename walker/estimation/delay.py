"""Delay of the walker's answers at the robot, estimated from the frames alone.

Sensor frame k names the frame whose answer was in force in the cycle before it (`command`); on a good link that
is k - 1. The difference to k - 1 is the delay of the whole loop in cycles: way to the walker, tick, way back,
wait for the boundary. No clocks are compared.
"""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame

TIME_CONSTANT: Final = 0.5
"""s; of the mean: it ignores a single late answer, and gaps that the guard handles."""
RESTART_GAP: Final = 0.25
"""s without a frame after which the mean begins anew: meanwhile the guard's commands were in force."""
MAX_DELAY: Final = 0.040
"""s; a delay counts as no more, so that one gap that the guard bridges does not end a walk."""


class DelayEstimator:
    """Mean delay of the answers; for one boot of a robot.

    Args:
        cycle: of the robot, s.
    """

    def __init__(self, cycle: float) -> None:
        self._cycle = cycle
        self._first: int | None = None
        self._seq = 0
        self.mean = 0.0
        """s; weighted with exp(-age / `TIME_CONSTANT`), each delay at most `MAX_DELAY`."""
        self.gap = 0.0
        """s by which the last answer in force was older than the mean; 0 before any was in force."""

    def update(self, frame: SensorFrame) -> None:
        """The next frame that is answered."""
        cycles = frame.seq - self._seq
        self._seq = frame.seq
        self.gap = 0.0
        if self._first is None:
            self._first = frame.seq
            return
        # What was in force before this controller's first answer is not its own.
        late = frame.seq - 1 - max(frame.command, self._first - 1)
        if frame.command >= self._first:
            self.gap = max(0.0, late * self._cycle - self.mean)
        if cycles * self._cycle > RESTART_GAP:
            self._first = frame.seq
            return
        weight = min(1.0, cycles * self._cycle / TIME_CONSTANT)
        self.mean += weight * (min(late * self._cycle, MAX_DELAY) - self.mean)
