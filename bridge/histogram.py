"""Counts of durations in logarithmic bins: percentiles of any length of run in constant memory."""

from __future__ import annotations

import math
from typing import Final

import msgspec

MIN_DURATION: Final = 1e-6
"""Upper edge of the first bin, s; it holds all shorter durations."""
MAX_DURATION: Final = 10.0
"""Upper edge of the last but one bin, s; longer durations fall into the last."""
BINS_PER_DECADE: Final = 20
"""A bin is 12 % wide: as exact as a percentile of scheduling noise needs to be."""

_N_EDGES: Final = round(math.log10(MAX_DURATION / MIN_DURATION) * BINS_PER_DECADE) + 1


class Percentiles(msgspec.Struct, frozen=True, kw_only=True):
    """Summary of a histogram in four numbers, s; all 0 without counts."""

    count: int
    p50: float
    p99: float
    max: float


class DurationHistogram:
    """Durations counted in fixed bins with the upper edges `MIN_DURATION * 10 ** (i / BINS_PER_DECADE)`."""

    def __init__(self) -> None:
        self._counts = [0] * (_N_EDGES + 1)  # the last bin holds those over `MAX_DURATION`
        self._count = 0
        self._max = 0.0

    def add(self, duration: float) -> None:
        """Count one duration, s; negative ones count as zero."""
        if duration <= MIN_DURATION:
            self._counts[0] += 1
        else:
            decades = math.log10(duration / MIN_DURATION)
            # The small allowance keeps a duration that lies on an edge in the bin that ends there.
            self._counts[min(math.ceil(decades * BINS_PER_DECADE - 1e-9), _N_EDGES)] += 1
        self._count += 1
        self._max = max(self._max, duration)

    def quantile(self, fraction: float) -> float:
        """Upper edge of the bin that holds the given fraction of the durations, at most the longest one, s.

        Args:
            fraction: 0..1, for example 0.99.
        """
        rank = max(1, math.ceil(fraction * self._count))
        seen = 0
        for i, count in enumerate(self._counts[:-1]):
            seen += count
            if count and seen >= rank:
                return min(MIN_DURATION * math.pow(10.0, i / BINS_PER_DECADE), self._max)
        return self._max

    def percentiles(self) -> Percentiles:
        """Count, median, 99 % and maximum."""
        return Percentiles(count=self._count, p50=self.quantile(0.5), p99=self.quantile(0.99), max=self._max)
