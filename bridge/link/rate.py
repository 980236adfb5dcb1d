"""A limit on the rate of events that other programs on the network can cause."""

from __future__ import annotations


class RateLimit:
    """Token bucket: bursts pass, a lasting flood does not. Not thread-safe.

    Args:
        rate: events per second in the long run.
        burst: events at once, after a pause.
    """

    def __init__(self, rate: float, burst: int) -> None:
        self._rate, self._burst = rate, float(burst)
        self._tokens, self._last = float(burst), 0.0

    def admits(self, now: float) -> bool:
        """Whether an event at `now` (monotonic, s) is within the bound; it then counts."""
        self._tokens = min(self._burst, self._tokens + self._rate * max(0.0, now - self._last))
        self._last = now
        if self._tokens < 1.0:
            return False
        self._tokens -= 1.0
        return True
