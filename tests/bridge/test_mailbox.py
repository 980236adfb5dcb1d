"""The mailbox between Zenoh's thread and the loop's: its order, its bound, and the end of each wait."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator

import pytest

from bridge.link.mailbox import Mailbox
from bridge.link.query import RateLimit
from tests.loops import TIMEOUT

WAIT = 0.1
"""s"""
RESCUE = 60.0
"""s after which a wait without an end is ended."""


@pytest.fixture
def alarms() -> Iterator[None]:
    """Alarms of this test are over after it."""
    before = signal.getsignal(signal.SIGALRM)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


def test_items_come_in_order_and_the_oldest_makes_room() -> None:
    mailbox: Mailbox[int] = Mailbox(3)
    for item in range(5):
        mailbox.put(item)
    assert mailbox.take(0.0) == 2
    assert mailbox.drain() == [3, 4]
    assert mailbox.take(0.0) is None
    mailbox.wake()
    mailbox.put(5)
    assert mailbox.drain() == [5]


def test_a_wait_ends_with_an_item_a_wake_or_its_time() -> None:
    mailbox: Mailbox[int] = Mailbox(3)
    mailbox.put(0)
    mailbox.drain()
    began = time.monotonic()
    assert mailbox.take(WAIT) is None  # what was put and drained before ends no wait
    assert time.monotonic() - began >= WAIT
    threading.Timer(WAIT, mailbox.put, [1]).start()
    assert mailbox.take(TIMEOUT) == 1
    began = time.monotonic()
    threading.Timer(WAIT, mailbox.wake).start()
    assert mailbox.take(TIMEOUT) is None
    assert time.monotonic() - began < 0.5 * TIMEOUT


def test_items_of_several_threads_all_arrive() -> None:
    mailbox: Mailbox[int] = Mailbox(4000)
    senders = [
        threading.Thread(target=lambda first: [mailbox.put(first + i) for i in range(1000)], args=(1000 * k,))
        for k in range(4)
    ]
    for sender in senders:
        sender.start()
    items = [mailbox.take(TIMEOUT) for _ in range(4000)]
    for sender in senders:
        sender.join(TIMEOUT)
    assert sorted(item for item in items if item is not None) == list(range(4000))


def test_a_signal_as_a_wait_runs_out_does_not_make_it_endless(alarms: None) -> None:
    """`queue.SimpleQueue.get` computes a negative time-out then, which is none (Python before 3.13)."""
    mailbox: Mailbox[int] = Mailbox(3)
    rescued = []

    def handle(_number: int, _frame: object) -> None:
        signal.signal(signal.SIGALRM, rescue)
        signal.setitimer(signal.ITIMER_REAL, RESCUE)
        time.sleep(2.0 * WAIT)  # past the end of the wait

    def rescue(_number: int, _frame: object) -> None:
        rescued.append(True)
        mailbox.wake()

    signal.signal(signal.SIGALRM, handle)
    signal.setitimer(signal.ITIMER_REAL, 0.5 * WAIT)
    assert mailbox.take(WAIT) is None
    assert not rescued


def test_a_burst_passes_and_a_flood_is_cut_to_the_rate() -> None:
    limit = RateLimit(rate=100.0, burst=10)
    assert [limit.admits(1.0) for _ in range(12)] == [True] * 10 + [False] * 2
    # A flood of 10 kHz for a second: a hundred pass.
    assert sum(limit.admits(1.0 + i * 1e-4) for i in range(1, 10_001)) == 100
