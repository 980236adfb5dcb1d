"""Bumpless transfer: a change of controllers without a jump of the joint angles."""

from __future__ import annotations

from typing import Final

from walker.functions import quintic

DURATION: Final = 1.0
"""s; a jump of 0.1 rad goes at 0.19 rad/s at most."""


class BumplessTransfer:
    """Adds the difference of the angles at the switch, and lets it decay to zero.

    Args:
        before: joint angles before the switch, rad.
        after: those that the new controller asks for at the same instant, rad.
    """

    def __init__(self, before: tuple[float, ...], after: tuple[float, ...]) -> None:
        self._jump = tuple(b - a for b, a in zip(before, after, strict=True))
        self._t = 0.0

    @property
    def done(self) -> bool:
        """Nothing is left."""
        return self._t >= DURATION

    def apply(self, angles: tuple[float, ...], dt: float) -> tuple[float, ...]:
        """The new controller's angles with the rest of the jump.

        Args:
            angles: of the new controller in this cycle, 25 slots, rad.
            dt: time since the last cycle, s.
        """
        self._t += dt
        left = quintic(1.0, 0.0, DURATION, self._t).position
        return tuple(a + left * jump for a, jump in zip(angles, self._jump, strict=True))
