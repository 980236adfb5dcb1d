"""Hands: opened and closed by a motor of their own, without a joint in the model.

The fingers are part of the forearm's or wrist's link; only their opening is followed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from bridge.body import Body
from bridge.body.joints import INDEX

OPENING_TIME: Final = 0.5
"""From closed to open, s (assumed)."""
_SLOTS: Final = (INDEX["LHand"], INDEX["RHand"])


class Hands:
    """Both hands of a body; an H21 has none, and its slots read 0.

    Args:
        body: Data sheet.
        angles: Start posture in frame order.
    """

    def __init__(self, body: Body, angles: Sequence[float]) -> None:
        self.slots: frozenset[int] = frozenset(_SLOTS if body.model == "H25" else ())
        """Frame slots that are hands of this body."""
        self._opening = {slot: angles[slot] for slot in self.slots}
        self._request = dict(self._opening)
        self._stiffness = dict.fromkeys(self.slots, 1.0)

    def latch(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        """Take over a request.

        Args:
            position: 25 in frame order; those of the hands are openings, clipped to 0..1.
            stiffness: 25 in frame order; a hand whose stiffness is not above 0 stays where it is.
        """
        for slot in self.slots:
            self._request[slot] = min(1.0, max(0.0, position[slot]))
            self._stiffness[slot] = min(1.0, stiffness[slot])

    def run_cycle(self, dt: float) -> None:
        """Move for dt seconds at the motor's pace; without stiffness the gear holds the hand where it is."""
        reach = dt / OPENING_TIME
        for slot in self.slots:
            if self._stiffness[slot] > 0.0:
                way = self._request[slot] - self._opening[slot]
                self._opening[slot] += min(reach, max(-reach, way))

    def put(self, position: list[float]) -> tuple[float, ...]:
        """Positions in frame order with the openings in their slots."""
        return _put(position, self._opening)

    def put_stiffness(self, stiffness: list[float]) -> tuple[float, ...]:
        """Stiffnesses in frame order with those of the hands in their slots."""
        return _put(stiffness, self._stiffness)


def _put(values: list[float], hands: dict[int, float]) -> tuple[float, ...]:
    for slot, value in hands.items():
        values[slot] = value
    return tuple(values)
