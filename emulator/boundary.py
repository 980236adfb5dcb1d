"""The boundary queue: work of other threads, done by the robot's loop between two cycles.

Queries come in Zenoh's threads; the robot belongs to its loop. A handler checks what it can on its own, hands
the rest over here, and sleeps until the loop has done it.
"""

from __future__ import annotations

import queue
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any, Final, TypeVar

from bridge.errors import LinkError

T = TypeVar("T")

MAX_WAIT: Final = 0.8
"""s a handler waits for the next boundary; a controller waits longer for its answer, and so hears why."""


class BoundaryQueue:
    """Calls waiting for the next cycle boundary; any thread may put them in, the loop's thread runs them.

    Args:
        wake: called after a call was put in, so that a loop that waits for something else looks here.
        max_wait: s that a caller waits.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None, max_wait: float = MAX_WAIT) -> None:
        self._wake, self._max_wait = wake, max_wait
        self._waiting: queue.SimpleQueue[tuple[Future[Any], Callable[[], Any]]] = queue.SimpleQueue()

    def call(self, work: Callable[[], T]) -> T:
        """The result of `work`, done by the loop at its next boundary; an exception of it is raised here.

        Raises:
            LinkError: the loop came to no boundary in time; the work is then never done.
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
