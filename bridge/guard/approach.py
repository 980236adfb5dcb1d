"""The approach: joints that were elsewhere, or limp, go to the command at limited speed, for a bounded time."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Final

from bridge.guard.config import ApproachSettings

_DURATION_FACTOR: Final = 1.5
"""Times the duration of the motion to the first command; a joint whose command moves on is let go then."""
_SHORTEST: Final = 0.5
"""s that an approach may take in any case."""


class Approach:
    """The joints on the way, each with the cycles that are left to it.

    A joint leaves when the rest of its way is less than a step of the approach, when it goes limp, or when its
    time is over, so that a command that keeps moving cannot hold it here.

    Args:
        settings: tolerance and speed.
        cycle: s
    """

    def __init__(self, settings: ApproachSettings, cycle: float) -> None:
        self._s, self._cycle = settings, cycle
        self._left: dict[int, int] = {}

    @property
    def slots(self) -> Collection[int]:
        """Joints that are limited to the speed of the settings; they arrive together."""
        return self._left.keys()

    def begin(self, distances: Mapping[int, float]) -> bool:
        """Take up joints, all of them if one is farther than the tolerance, else none.

        Args:
            distances: distance of each joint from its command, rad.

        Returns:
            Whether they were taken up.
        """
        farthest = max(distances.values(), default=0.0)
        if farthest <= self._s.tolerance:
            return False
        time = max(_DURATION_FACTOR * farthest / self._s.speed, _SHORTEST)
        self._left |= dict.fromkeys(distances, math.ceil(time / self._cycle))
        return True

    def advance(self, distances: Mapping[int, float]) -> None:
        """One cycle is done; joints that arrived, went limp or had their time leave.

        Args:
            distances: distance that is left to each stiff joint, rad.
        """
        step = self._s.speed * self._cycle
        self._left = {
            slot: left - 1 for slot, left in self._left.items() if left > 1 and distances.get(slot, 0.0) > step
        }

    def clear(self) -> None:
        """No joint is on the way."""
        self._left = {}
