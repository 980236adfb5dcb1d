"""Network conditions of one direction: when each packet arrives, if it does.

The quantities are those of Linux' netem, which not every kernel has: delay and jitter (uniform), loss,
reordering (a packet that is not delayed overtakes the others), rate.
"""

from __future__ import annotations

import msgspec
import numpy as np

QUEUE = 1000
"""Packets that wait when the rate is limited; more are dropped."""


class NetworkConditions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Conditions of one direction; the default passes every packet on at once."""

    delay: float = 0.0
    """s"""
    jitter: float = 0.0
    """s; the delay is drawn from `delay` +- `jitter`."""
    loss: float = 0.0
    """Fraction of packets that never arrive, 0 to 1."""
    reorder: float = 0.0
    """Fraction of packets that are not delayed at all; without any, jitter never changes the order."""
    rate: float = 0.0
    """bit/s; 0: no bound."""
    outage: bool = False
    """Nothing arrives."""


class Channel:
    """Computes when each packet of one direction arrives.

    Args:
        conditions: Initial ones; the attribute `conditions` may be set at any time.
        generator: Source of jitter, loss and reordering.
    """

    def __init__(self, conditions: NetworkConditions, generator: np.random.Generator) -> None:
        self.conditions = conditions
        self._random = generator
        self._link_free = 0.0
        self._last = 0.0

    def arrival(self, now: float, size: int) -> float | None:
        """Time at which a packet of `size` bytes sent at `now` arrives, s; None: never."""
        w = self.conditions
        lost, early, shift = map(float, self._random.random(3))
        if w.outage or lost < w.loss:
            return None
        sent = now
        if w.rate > 0.0:
            duration = 8.0 * size / w.rate
            if self._link_free - now > QUEUE * duration:
                return None
            sent = self._link_free = max(now, self._link_free) + duration
        if early < w.reorder:
            return sent
        at = sent + max(0.0, w.delay + w.jitter * (2.0 * shift - 1.0))
        self._last = at = max(at, self._last)
        return at
