"""What a network does to packets, one direction at a time: when each arrives, if it does.

The quantities are those of Linux' netem, which not every kernel has: delay and jitter (uniform), loss,
reordering (a packet that is not delayed overtakes the others), rate.
"""

from __future__ import annotations

import msgspec
import numpy as np

QUEUE = 1000
"""Packets that wait for a narrow line; more are dropped."""


class Weather(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One direction of a network; the default does nothing."""

    delay: float = 0.0
    """s"""
    jitter: float = 0.0
    """s; the delay is drawn from `delay` +- `jitter`."""
    loss: float = 0.0
    """Share of packets that never arrive, 0 to 1."""
    reorder: float = 0.0
    """Share of packets that are not delayed at all; without any, jitter never changes the order."""
    rate: float = 0.0
    """bit/s; 0: no bound."""
    cut: bool = False
    """Nothing arrives."""


class Channel:
    """The fate of each packet.

    Args:
        weather: to begin with; `weather` may be set anew at any time.
        generator: for all that is random.
    """

    def __init__(self, weather: Weather, generator: np.random.Generator) -> None:
        self.weather = weather
        self._random = generator
        self._line_free = 0.0
        self._last = 0.0

    def arrival(self, now: float, size: int) -> float | None:
        """Time at which a packet of `size` bytes sent at `now` arrives, s; None: never."""
        w = self.weather
        lost, early, shift = map(float, self._random.random(3))
        if w.cut or lost < w.loss:
            return None
        sent = now
        if w.rate > 0.0:
            duration = 8.0 * size / w.rate
            if self._line_free - now > QUEUE * duration:
                return None
            sent = self._line_free = max(now, self._line_free) + duration
        if early < w.reorder:
            return sent
        at = sent + max(0.0, w.delay + w.jitter * (2.0 * shift - 1.0))
        self._last = at = max(at, self._last)
        return at
