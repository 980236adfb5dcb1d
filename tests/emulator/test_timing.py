"""Cycle timer and histogram against a clock that only moves when told to."""

from __future__ import annotations

import math
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.errors import FrameError, LinkError
from bridge.histogram import BINS_PER_DECADE, MAX_DURATION, MIN_DURATION, DurationHistogram
from emulator.timing import BoundaryQueue, CycleTimer
from tests.loops import TIMEOUT

MS = 1_000_000


class FakeClock:
    """A clock, ns, whose sleep returns late by a chosen number of nanoseconds."""

    def __init__(self) -> None:
        self.now = 5_000_000_123
        self.oversleep = 0
        self.sleeps: list[float] = []

    def __call__(self) -> int:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.sleeps.append(seconds)
        self.now += round(seconds * 1e9) + self.oversleep


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


def timer(clock: FakeClock) -> CycleTimer:
    return CycleTimer(0.01, clock=clock, sleep=clock.sleep)


def test_deadlines_are_whole_periods_from_the_start(clock: FakeClock) -> None:
    start, t = clock.now, timer(clock)
    wakes = []
    for k in range(5):
        assert t.wait() == 0.0
        wakes.append(clock.now - start)
        clock.now += k * MS
    assert wakes == [10 * MS, 20 * MS, 30 * MS, 40 * MS, 50 * MS]


def test_sleep_that_returns_early_is_repeated(clock: FakeClock) -> None:
    start = clock.now
    naps = iter([-1000, 0])

    def sleep(seconds: float) -> None:
        clock.oversleep = next(naps)
        clock.sleep(seconds)

    t = CycleTimer(0.01, clock=clock, sleep=sleep)
    assert t.wait() == 0.0
    assert clock.now - start == 10 * MS
    assert clock.sleeps == [0.01, 1e-6]


def test_cycle_that_overran_by_less_than_a_period_is_taken_late_and_caught_up(clock: FakeClock) -> None:
    start, t = clock.now, timer(clock)
    t.wait()
    clock.now += 13 * MS
    assert t.wait() == 0.003
    assert clock.now - start == 23 * MS
    assert t.wait() == 0.0
    assert clock.now - start == 30 * MS
    assert t.times.skipped == 0


def test_after_a_stall_the_passed_deadlines_are_counted_and_no_burst_follows(clock: FakeClock) -> None:
    start, t = clock.now, timer(clock)
    t.wait()
    clock.now += 57 * MS  # from 10 to 67 ms: the deadlines 20..50 have passed altogether, 60 is taken late
    assert t.wait() == 0.007
    assert t.times.skipped == 4
    wakes = []
    for _ in range(3):
        t.wait()
        wakes.append((clock.now - start) // MS)
    assert wakes == [70, 80, 90]
    assert t.times.cycles == 5
    assert t.times.cycles + t.times.skipped == 9  # as many as there were deadlines


@given(st.lists(st.integers(min_value=0, max_value=200 * MS), min_size=1, max_size=40))
def test_every_deadline_is_either_waited_for_or_skipped(work: list[int]) -> None:
    clock = FakeClock()
    start, t = clock.now, timer(clock)
    for w in work:
        lateness = t.wait()
        assert 0.0 <= lateness < 0.01
        assert clock.now - start - round(lateness * 1e9) == (t.times.cycles + t.times.skipped) * 10 * MS
        clock.now += w


def test_restart_forgets_a_pause(clock: FakeClock) -> None:
    t = timer(clock)
    t.wait()
    clock.now += 3000 * MS
    t.restart()
    resumed = clock.now
    assert t.wait() == 0.0
    assert clock.now - resumed == 10 * MS
    assert t.times.skipped == 0
    assert t.times.work.max == 0.0


def test_work_is_the_time_between_waking_and_waiting_again(clock: FakeClock) -> None:
    t = timer(clock)
    t.wait()
    for _ in range(3):
        clock.now += 4 * MS
        t.wait()
    work = t.times.work
    assert (work.count, work.max) == (3, 0.004)
    assert work.p50 == pytest.approx(0.004, rel=10 ** (1 / BINS_PER_DECADE) - 1)


@given(
    st.lists(st.floats(min_value=0.0, max_value=100.0), min_size=1, max_size=200), st.sampled_from([0.5, 0.99])
)
def test_quantiles_agree_with_sorting_within_a_bin(durations: list[float], share: float) -> None:
    histogram = DurationHistogram()
    for d in durations:
        histogram.add(d)
    exact = sorted(durations)[math.ceil(share * len(durations)) - 1]
    got = histogram.quantile(share)
    if exact <= MIN_DURATION:
        assert got == min(MIN_DURATION, max(durations))
    elif exact <= MAX_DURATION:
        assert exact * (1 - 1e-6) <= got <= exact * 10 ** (1 / BINS_PER_DECADE) * (1 + 1e-6)
    else:
        assert got == max(durations)
    found = histogram.percentiles()
    assert (found.count, found.max) == (len(durations), max(durations))


def in_thread(queue: BoundaryQueue, work: object) -> tuple[threading.Thread, list[object]]:
    """A thread that calls `work` through the queue, and the list its result or error ends in."""
    results: list[object] = []

    def target() -> None:
        try:
            results.append(queue.call(work))  # type: ignore[arg-type]
        except Exception as error:
            results.append(error)

    thread = threading.Thread(target=target)
    thread.start()
    return thread, results


def test_the_work_is_done_in_the_thread_of_the_loop() -> None:
    arrived = threading.Event()
    queue = BoundaryQueue(wake=arrived.set, max_wait=TIMEOUT)
    thread, results = in_thread(queue, threading.get_ident)
    assert arrived.wait(TIMEOUT)
    assert results == []
    queue.run()
    thread.join(TIMEOUT)
    assert results == [threading.get_ident()]


def test_an_error_reaches_the_caller_and_not_the_loop() -> None:
    arrived = threading.Event()
    queue = BoundaryQueue(wake=arrived.set, max_wait=TIMEOUT)

    def fail() -> None:
        raise FrameError("no such thing")

    thread, results = in_thread(queue, fail)
    assert arrived.wait(TIMEOUT)
    queue.run()
    thread.join(TIMEOUT)
    assert isinstance(results[0], FrameError)


def test_work_that_nobody_waits_for_any_more_is_not_done() -> None:
    queue = BoundaryQueue(max_wait=0.01)
    done: list[int] = []
    with pytest.raises(LinkError, match="no cycle boundary"):
        queue.call(lambda: done.append(1))
    queue.run()
    assert done == []
