"""A bounded queue from Zenoh's thread to the loop's, with a wait that times out."""

from __future__ import annotations

import queue
from typing import Generic, TypeVar

T = TypeVar("T")


class Mailbox(Generic[T]):
    """A bounded first-in first-out queue; when it is full, the oldest item makes room.

    Zenoh's own channels have no receive with a time-out, and a blocked receive does not see Ctrl-C.

    Args:
        size: items kept.
    """

    def __init__(self, size: int) -> None:
        self._queue: queue.SimpleQueue[T | None] = queue.SimpleQueue()
        self._size = size

    def put(self, item: T) -> None:
        """Leave an item; never waits."""
        while self._queue.qsize() >= self._size:
            try:
                self._queue.get_nowait()
            except queue.Empty:  # taken meanwhile
                break
        self._queue.put(item)

    def wake(self) -> None:
        """End a wait without an item."""
        self._queue.put(None)

    def take(self, timeout: float) -> T | None:
        """The oldest item, waiting up to `timeout` s; None when none came or the wait was ended."""
        try:
            return self._queue.get(timeout=timeout)
        except queue.Empty:
            return None

    def drain(self) -> list[T]:
        """All items, oldest first, without waiting."""
        items: list[T] = []
        while True:
            try:
                item = self._queue.get_nowait()
            except queue.Empty:
                return items
            if item is not None:
                items.append(item)
