from __future__ import annotations

import itertools
import random

import pytest

from bridge.adapters.lola.server import GRACE, PERIOD, SLACK, PacketTimer
from tests.loops import repeat_while

MS = 1_000_000


class Clock:
    def __init__(self) -> None:
        self.now = 0

    def __call__(self) -> int:
        return self.now


def packets(timer: PacketTimer, clock: Clock, frames: list[int], end: int) -> list[tuple[int, int]]:
    """Times of the packets and the frames in them, with frames that come at given times; a step is 0.1 ms."""
    sent, newest, left = [], -1, list(enumerate(frames))
    for _ in range(0, end, MS // 10):
        clock.now += MS // 10
        for _ in repeat_while(lambda: left and left[0][1] <= clock.now):
            newest, arrived = left.pop(0)
            timer.frame(arrived)
        if timer.due():
            sent.append((clock.now, newest))
    return sent


def test_packets_follow_frames_and_do_not_pass_their_jitter_on() -> None:
    """Frames every 12 ms, up to 0.8 ms early or late: the packets' gaps stay within 0.3 ms of 12."""
    clock, random_ = Clock(), random.Random(1)
    frames = [5 * MS + k * PERIOD + round(random_.uniform(-0.8, 0.8) * MS) for k in range(500)]
    timer = PacketTimer(0.012, clock)
    sent = packets(timer, clock, frames, frames[-1])[20:]
    gaps = [b[0] - a[0] for a, b in itertools.pairwise(sent)]
    assert max(gaps) <= PERIOD + 0.3 * MS and min(gaps) >= PERIOD - 0.3 * MS
    assert [frame for _, frame in sent] == list(range(sent[0][1], sent[0][1] + len(sent)))  # each frame once
    assert timer.skipped == 0


def test_a_robot_whose_clock_runs_otherwise_is_followed() -> None:
    """200 ppm off for five minutes is five cycles; no packet repeats a frame."""
    clock = Clock()
    frames = [round(k * PERIOD * 1.0002) for k in range(1, 5000)]
    timer = PacketTimer(0.012, clock)
    sent = packets(timer, clock, frames, frames[-1])
    late = [at - frames[frame] for at, frame in sent[20:]]
    assert min(late) > 0.5 * SLACK and max(late) < 2.0 * SLACK
    assert timer.repeated <= 1


def test_a_late_frame_is_waited_for_and_a_missing_one_is_not() -> None:
    clock = Clock()
    frames = [k * PERIOD for k in range(1, 40)]
    frames[20] += SLACK + GRACE // 2  # late, in time for the grace
    del frames[30]
    timer = PacketTimer(0.012, clock)
    sent = packets(timer, clock, frames, frames[-1])
    assert timer.repeated == 1
    gaps = [b[0] - a[0] for a, b in itertools.pairwise(sent[2:])]
    assert max(gaps) < PERIOD + GRACE + 0.3 * MS


@pytest.mark.parametrize("cycle", [0.010, 0.020])
def test_for_another_cycle_the_clock_alone_sets_the_beat(cycle: float) -> None:
    clock = Clock()
    frames = [round(k * cycle * 1e9) for k in range(1, 400)]
    timer = PacketTimer(cycle, clock)
    sent = packets(timer, clock, frames, frames[-1])
    assert {b[0] - a[0] for a, b in itertools.pairwise(sent)} == {PERIOD}


def test_a_loop_that_was_held_up_sends_no_burst() -> None:
    clock = Clock()
    timer = PacketTimer(0.010, clock)
    clock.now = 10 * PERIOD + 1
    assert timer.due() and not timer.due()
    assert timer.skipped == 9


def test_late_frames_at_the_start_cost_the_client_no_time_for_long() -> None:
    """The first frames come 5 ms late, as of a robot that has just started: it is made up in half a second."""
    clock = Clock()
    frames = [k * PERIOD + (5 * MS if k < 4 else 0) for k in range(1, 200)]
    timer = PacketTimer(0.012, clock)
    sent = packets(timer, clock, frames, frames[-1])
    assert max(at - frames[frame] for at, frame in sent[80:]) < 1.5 * SLACK
