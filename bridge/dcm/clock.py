"""The DCM's clock: milliseconds in a signed 4-byte integer that wraps after 49.7 days."""

from __future__ import annotations

from typing import Final

LOWEST: Final = -(2**31)
HIGHEST: Final = 2**31 - 1


def wrapped(milliseconds: int) -> int:
    """The 4-byte integer that stands for a number of milliseconds."""
    return (milliseconds - LOWEST) % 2**32 + LOWEST


class Clock:
    """Counts cycles and tells the time of the present cycle boundary.

    Inside, time is a plain count of milliseconds since the start; outside, it is the wrapped integer.

    Args:
        cycle: cycle time, s.
        start: what the clock shows at the start, ms.
    """

    def __init__(self, cycle: float, start: int) -> None:
        self._cycle, self._start = 1000.0 * cycle, start
        self._cycles = 0
        self.now = 0
        """Time of the present boundary, ms since the start."""
        self.previous = -round(self._cycle)
        """Time at which the last cycle was run."""

    def tick(self) -> None:
        """One cycle has been run."""
        self._cycles += 1
        self.previous, self.now = self.now, round(self._cycles * self._cycle)

    def skip(self) -> None:
        """One cycle has passed in which the DCM did nothing."""
        self._cycles += 1
        self.now = round(self._cycles * self._cycle)

    def shown(self, offset: int = 0) -> int:
        """What the clock shows `offset` ms from now."""
        return wrapped(self._start + self.now + offset)

    def since_start(self, shown: int) -> int:
        """The time that a shown one means, ms since the start: the one less than 24.8 days from now."""
        return self.now + wrapped(shown - self._start - self.now)
