"""The boundaries of the DCM cycle: deadlines of the wall clock, counted misses, and work of other threads.

Queries arrive in Zenoh's threads; the robot belongs to its loop. A handler checks its own part, queues the
rest here, and sleeps until the loop has done it between two cycles.
"""

from __future__ import annotations

import math
import queue
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any, Final, TypeVar

import msgspec

from bridge.errors import LinkError
from bridge.histogram import DurationHistogram, Percentiles

NANOSECONDS: Final = 1_000_000_000


class CycleTimes(msgspec.Struct, frozen=True, kw_only=True):
    """Punctuality of the cycles so far, by the wall clock."""

    cycles: int
    """Deadlines that the loop waited for."""
    skipped: int
    """Deadlines already over when the loop began to wait, left out."""
    lateness: Percentiles
    """Wake-up after the deadline."""
    work: Percentiles
    """From the wake-up to the next call of `wait`."""


class CycleTimer:
    """Divides wall-clock time into cycles by absolute deadlines, so that lateness never adds up.

    A deadline that has already passed is taken at once, late. When a whole period or more has passed since
    it, the deadlines in between are counted as skipped and left out: a stalled robot continues in the
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
        """Restart: the next deadline is one period from now; for the start and after a pause."""
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
        """Deadlines left out since the timer began."""
        return self._skipped

    @property
    def times(self) -> CycleTimes:
        """Counters and percentiles since the timer began."""
        return CycleTimes(
            cycles=self._cycles,
            skipped=self._skipped,
            lateness=self._lateness.percentiles(),
            work=self._work.percentiles(),
        )


T = TypeVar("T")

MAX_WAIT: Final = 3.0
"""s a handler waits for the next boundary; a controller waits longer for its answer, and so gets the reason."""


class BoundaryQueue:
    """Calls waiting for the next cycle boundary; any thread may put them in, the loop's thread runs them.

    Args:
        wake: called after a call is queued, so that a loop that waits for something else checks the queue.
        max_wait: s that a caller waits.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None, max_wait: float = MAX_WAIT) -> None:
        self._wake, self._max_wait = wake, max_wait
        self._waiting: queue.SimpleQueue[tuple[Future[Any], Callable[[], Any]]] = queue.SimpleQueue()

    def call(self, work: Callable[[], T]) -> T:
        """The result of `work`, done by the loop at its next boundary; an exception of it is raised here.

        Raises:
            LinkError: the loop reached no boundary in time; the work is then never done.
        """
        done: Future[T] = Future()
        self._waiting.put((done, work))
        self._wake()
        try:
            return done.result(self._max_wait)
        except FutureTimeoutError:
            if done.cancel():
                raise LinkError(
                    f"The robot reached no cycle boundary within {self._max_wait:g} s and dropped the request; "
                    "send it again when it runs."
                ) from None
            return done.result()

    def run(self) -> None:
        """Do everything that waits, oldest first; to be called by the loop, between two cycles."""
        for _ in range(self._waiting.qsize()):
            done, work = self._waiting.get()
            if not done.set_running_or_notify_cancel():
                continue
            try:
                done.set_result(work())
            except BaseException as error:
                done.set_exception(error)
                if not isinstance(error, Exception):
                    raise
