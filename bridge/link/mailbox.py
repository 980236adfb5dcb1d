"""Payloads handed from Zenoh's thread to the loop's: bounded, ordered, with a wait that ends."""

from __future__ import annotations

import queue

import zenoh


class Mailbox:
    """A bounded first-in first-out queue of payloads.

    Zenoh's own channels have no receive with a time-out, and a blocked receive does not see Ctrl-C.

    Args:
        size: payloads kept; when full, new ones are dropped and counted.
    """

    def __init__(self, size: int) -> None:
        self._queue: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._size = size
        self.dropped = 0
        """Payloads that found the box full."""

    def receive(self, sample: zenoh.Sample) -> None:
        """Callback for a subscriber."""
        if self._queue.qsize() < self._size:
            self._queue.put(sample.payload.to_bytes())
        else:
            self.dropped += 1

    def wake(self) -> None:
        """End a wait without a payload."""
        self._queue.put(None)

    def take(self, timeout: float) -> bytes | None:
        """The oldest payload, waiting up to `timeout` s; None when none came or the wait was ended."""
        try:
            return self._queue.get(timeout=timeout)
        except queue.Empty:
            return None

    def drain(self) -> list[bytes]:
        """All payloads, oldest first, without waiting."""
        payloads = []
        while True:
            try:
                payload = self._queue.get_nowait()
            except queue.Empty:
                return payloads
            if payload is not None:
                payloads.append(payload)
