"""How late the walker's answers are at the robot, by the frames alone, and whether a walk bears it.

Sensor frame k names the frame whose answer was in force in the cycle before it (`command`); on a good link that
is k - 1. What is missing to that is the delay of the whole loop in cycles: way to the walker, tick, way back,
wait for the boundary. No clocks are compared.
"""

from __future__ import annotations

from typing import Final

from bridge.messages import SensorFrame

BUDGETS: Final = {"static": 0.025, "dynamic": 0.025}
BUDGET: Final = 0.015
"""s by which answers may be late, in the mean of about `SPAN`, and a walk still begins or goes on; `BUDGET` for
gaits that are not named. Measured on emulated robots, see docs/weather.md: the static gait bears two late
cycles, and on an ideal robot falls with three; the dynamic one bears three."""
SPAN: Final = 0.5
"""s; time constant of the mean: a single late answer is none of its business, nor is what the guard sees to."""
ANEW: Final = 0.25
"""s without a frame after which the mean begins anew: what was in force meanwhile was the guard's."""
LONGEST: Final = 0.040
"""s; a delay counts as no more, so that one gap that the guard bridges does not end a walk."""


class DelayWatch:
    """Mean delay of the answers; for one boot of a robot.

    Args:
        cycle: of the robot, s.
    """

    def __init__(self, cycle: float) -> None:
        self._cycle = cycle
        self._first: int | None = None
        self._seq = 0
        self.mean = 0.0
        """s; weighted with exp(-age / `SPAN`), each delay at most `LONGEST`."""
        self.gap = 0.0
        """s by which the last answer in force was older than the mean; 0 before any was in force."""

    def take(self, frame: SensorFrame) -> None:
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
        if cycles * self._cycle > ANEW:
            self._first = frame.seq
            return
        weight = min(1.0, cycles * self._cycle / SPAN)
        self.mean += weight * (min(late * self._cycle, LONGEST) - self.mean)


def budget(gait: str) -> float:
    """Mean delay that a gait bears, s."""
    return BUDGETS.get(gait, BUDGET)
