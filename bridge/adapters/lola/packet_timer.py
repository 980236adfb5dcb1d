"""Times of a served LoLA's packets: every 12 ms, in phase with a robot that has the same cycle.

A robot behind a network has its own clock. If its cycle is LoLA's, the packets follow its frames: each goes out
`SLACK` after its frame usually comes, by the median of the last frames, so that neither the frames' jitter is
passed on, nor a few late ones at the start cost the client its time. A packet waits up to `GRACE` for a late
frame. For a robot with another cycle this machine's clock alone sets the times, and a packet holds the newest
frame.
"""

from __future__ import annotations

import statistics
import time
from collections import deque
from collections.abc import Callable
from typing import Final

from bridge.adapters.lola.schema import CYCLE

_NS: Final = 1_000_000_000
PERIOD: Final = round(CYCLE * _NS)
"""ns"""
SLACK: Final = 1_000_000
"""ns from a frame's usual arrival to its packet."""
GRACE: Final = 1_000_000
"""ns that a packet waits for a late frame."""
_WINDOW: Final = 31
"""Frames whose median arrival the packets follow."""
_PACE: Final = 100_000
"""ns by which the phase moves at most from one packet to the next."""
_SAME_CYCLE: Final = 1e-6
"""s"""


class PacketTimer:
    """Says when each packet is due.

    Args:
        cycle: of the robot, s.
        clock: monotonic clock, ns.
    """

    def __init__(self, cycle: float, clock: Callable[[], int] = time.monotonic_ns) -> None:
        self._clock = clock
        self.follows = abs(cycle - CYCLE) < _SAME_CYCLE
        """The robot's cycle is LoLA's."""
        self._deadline = clock() + PERIOD
        self._locked = self._fresh = False
        self._errors: deque[int] = deque(maxlen=_WINDOW)
        """Lateness of the last frames relative to the phase, ns."""
        self.skipped = 0
        """Packets left out because the loop was held up past their time."""
        self.repeated = 0
        """Packets that went out with the frame of the one before."""

    def frame(self, arrived: int) -> None:
        """Correct the phase by a frame.

        Args:
            arrived: monotonic clock, ns.
        """
        self._fresh = True
        if not self.follows:
            return
        error = arrived + SLACK - self._deadline
        error -= round(error / PERIOD) * PERIOD
        self._errors.append(error)
        middle = round(statistics.median(self._errors))
        step = max(-_PACE, min(middle, _PACE)) if self._locked else middle
        self._locked = True
        self._deadline += step
        self._errors = deque((earlier - step for earlier in self._errors), maxlen=_WINDOW)

    @property
    def wait(self) -> float:
        """Time until `due` is to be asked again, s."""
        return max(0.0, (self._end - self._clock()) / _NS)

    @property
    def _end(self) -> int:
        return self._deadline + (GRACE if self.follows and self._locked and not self._fresh else 0)

    def due(self) -> bool:
        """Whether a packet is to go out now; True counts it as sent."""
        now = self._clock()
        if now < self._end:
            return False
        passed = (now - self._deadline) // PERIOD
        self.skipped += passed
        self._deadline += (passed + 1) * PERIOD
        self.repeated += not self._fresh
        self._fresh = False
        return True
