"""Work handed from other threads to the loop."""

from __future__ import annotations

import threading

import pytest

from bridge.errors import FrameError, LinkError
from emulator.timing import BoundaryQueue


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
    queue = BoundaryQueue(wake=arrived.set)
    thread, results = in_thread(queue, threading.get_ident)
    assert arrived.wait(10.0)
    assert results == []
    queue.run()
    thread.join(10.0)
    assert results == [threading.get_ident()]


def test_an_error_reaches_the_caller_and_not_the_loop() -> None:
    arrived = threading.Event()
    queue = BoundaryQueue(wake=arrived.set)

    def fail() -> None:
        raise FrameError("no such thing")

    thread, results = in_thread(queue, fail)
    assert arrived.wait(10.0)
    queue.run()
    thread.join(10.0)
    assert isinstance(results[0], FrameError)


def test_work_that_nobody_waits_for_any_more_is_not_done() -> None:
    queue = BoundaryQueue(max_wait=0.01)
    done: list[int] = []
    with pytest.raises(LinkError, match="no cycle boundary"):
        queue.call(lambda: done.append(1))
    queue.run()
    assert done == []
