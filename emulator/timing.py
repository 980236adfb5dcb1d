"""The wall clock of the DCM cycle: absolute deadlines and counted misses."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Final

import msgspec

from bridge.histogram import DurationHistogram, Percentiles

NANOSECONDS: Final = 1_000_000_000


class CycleTimes(msgspec.Struct, frozen=True, kw_only=True):
    """How well the cycles kept to the wall clock so far."""

    cycles: int
    """Deadlines that were waited for."""
    skipped: int
    """Deadlines that had passed altogether when the cycle came back to wait, and were left out."""
    lateness: Percentiles
    """Wake-up after the deadline."""
    work: Percentiles
    """From the wake-up to the next call of `wait`."""


class CycleTimer:
    """Divides wall-clock time into cycles by absolute deadlines, so that lateness never adds up.

    A deadline that has already passed is taken at once, late. When a whole period or more has passed since
    it, the deadlines in between are counted as skipped and left out: a robot that stalled goes on in the
    present and never runs cycles in a burst.

    Args:
        period: cycle time, s.
        clock: monotonic clock, ns.
        sleep: sleeps for seconds; may return late, and early by the clock's resolution.

    Raises:
        ValueError: the period is not a positive number of nanoseconds.
    """

    def __init__(
        self,
        period: float,
        *,
        clock: Callable[[], int] = time.monotonic_ns,
        sleep: Callable[[float], object] = time.sleep,
    ) -> None:
        if not math.isfinite(period) or round(period * NANOSECONDS) < 1:
            raise ValueError(f"the period is {period} s; a positive number is expected")
        self._period = round(period * NANOSECONDS)
        self._clock, self._sleep = clock, sleep
        self._lateness, self._work = DurationHistogram(), DurationHistogram()
        self._cycles = self._skipped = 0
        self._woke: int | None = None
        self._deadline = clock() + self._period

    def restart(self) -> None:
        """Begin anew: the next deadline is one period from now; for the start and after a pause."""
        self._woke = None
        self._deadline = self._clock() + self._period

    def wait(self) -> float:
        """Sleep to the next deadline.

        Returns:
            Lateness: time from the deadline to the wake-up, s, never negative.
        """
        now = self._clock()
        if self._woke is not None:
            self._work.add((now - self._woke) / NANOSECONDS)
        passed = (now - self._deadline) // self._period
        if passed > 0:
            self._skipped += passed
            self._deadline += passed * self._period
        while now < self._deadline:
            self._sleep((self._deadline - now) / NANOSECONDS)
            now = self._clock()
        lateness = (now - self._deadline) / NANOSECONDS
        self._lateness.add(lateness)
        self._cycles += 1
        self._woke = now
        self._deadline += self._period
        return lateness

    @property
    def skipped(self) -> int:
        """Deadlines left out since the timer was made."""
        return self._skipped

    @property
    def times(self) -> CycleTimes:
        """Counters and percentiles since the timer was made."""
        return CycleTimes(
            cycles=self._cycles,
            skipped=self._skipped,
            lateness=self._lateness.percentiles(),
            work=self._work.percentiles(),
        )
