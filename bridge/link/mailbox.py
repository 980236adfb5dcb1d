"""A bounded queue from Zenoh's thread to the loop's, with a wait that times out."""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class Mailbox(Generic[T]):
    """A bounded first-in first-out queue; when it is full, the oldest item makes room.

    One thread takes; any thread, and a signal handler, may do the rest.

    Zenoh's own channels have no receive with a time-out, and a blocked receive does not see Ctrl-C. Python's
    `queue.SimpleQueue` waits forever when a signal comes as the time-out ends (before Python 3.13).

    Args:
        size: items kept.
    """

    def __init__(self, size: int) -> None:
        self._items: deque[T | None] = deque(maxlen=size)
        self._empty = threading.Lock()
        """Released by each `put`; held since then: nothing has been put."""

    def put(self, item: T) -> None:
        """Leave an item; never waits."""
        self._put(item)

    def wake(self) -> None:
        """End a wait without an item."""
        self._put(None)

    def _put(self, item: T | None) -> None:
        self._items.append(item)
        if self._empty.locked():
            try:
                self._empty.release()
            except RuntimeError:
                return  # by another thread

    def take(self, timeout: float) -> T | None:
        """The oldest item, waiting up to `timeout` s; None: time-out, or `wake`."""
        deadline = time.monotonic() + timeout
        while True:
            try:
                return self._items.popleft()
            except IndexError:
                if not self._empty.acquire(timeout=max(0.0, deadline - time.monotonic())):
                    return None

    def drain(self) -> list[T]:
        """All items, oldest first, without waiting."""
        items: list[T] = []
        while True:
            try:
                item = self._items.popleft()
            except IndexError:
                return items
            if item is not None:
                items.append(item)
