"""The delay that the walker sees in the frames, against answers whose delay is known."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from bridge.messages import SensorFrame
from tests.frames import standing_frame
from walker.gaits.catalogue import gait_kind
from walker.monitor import DELAY_TIME_CONSTANT, DelayEstimator

CYCLE = 0.01


def frame(seq: int, command: int) -> SensorFrame:
    return standing_frame(seq, time=CYCLE * seq, command=command)


def watched(in_force: Callable[[int], int], first: int = 0, last: int = 500) -> DelayEstimator:
    estimator = DelayEstimator(CYCLE)
    for seq in range(first, last):
        estimator.update(frame(seq, in_force(seq)))
    return estimator


def test_a_link_that_answers_in_time_has_no_delay() -> None:
    assert watched(lambda seq: seq - 1).mean == 0.0


@pytest.mark.parametrize("cycles", [1, 2, 3])
def test_answers_that_are_late_by_some_cycles_are_seen_as_that(cycles: int) -> None:
    estimator = watched(lambda seq: seq - 1 - cycles)
    assert estimator.mean == pytest.approx(cycles * CYCLE, rel=1e-3)
    assert (estimator.mean > gait_kind("static").max_delay) == (cycles > 2)
    assert (estimator.mean > gait_kind("dynamic").max_delay) == (cycles > 2)


def test_the_mean_forgets_with_its_time_constant() -> None:
    # From no delay to 30 ms: after one time constant 1 - 1/e of it.
    n = round(DELAY_TIME_CONSTANT / CYCLE)
    estimator = watched(lambda seq: seq - 1 if seq < 100 else seq - 4, last=100 + n)
    assert estimator.mean == pytest.approx(0.03 * (1.0 - math.exp(-1.0)), rel=0.02)


def test_a_cut_that_the_guard_sees_to_does_not_count_for_long() -> None:
    # 0.2 s without an answer, then as before.
    estimator = DelayEstimator(CYCLE)
    for seq in range(300):
        estimator.update(frame(seq, 99 if 100 <= seq < 120 else seq - 1))
        assert estimator.mean < gait_kind("static").max_delay
    assert estimator.mean < 1e-3


def test_a_gap_is_how_much_older_than_usual_the_answer_in_force_is() -> None:
    estimator = DelayEstimator(CYCLE)
    for seq in range(100):
        estimator.update(frame(seq, seq - 1))
        assert estimator.gap == 0.0
    for seq in range(100, 112):
        estimator.update(frame(seq, 98))
        assert estimator.gap == pytest.approx(max(0.0, CYCLE * (seq - 99) - estimator.mean), abs=CYCLE * 0.1)
    estimator.update(frame(112, 111))
    assert estimator.gap == 0.0


def test_a_gap_in_the_frames_is_one_in_the_answers_but_delay_is_none() -> None:
    estimator = watched(lambda seq: seq - 3)
    assert estimator.gap < 0.1 * CYCLE
    estimator.update(frame(540, 499))
    assert estimator.gap == pytest.approx(38 * CYCLE, abs=0.1 * CYCLE)
