"""The end of a quick step whose commands break off: both feet side by side, before the robot tips over.

A biped whose joints stop in a quick step tips over within a few tenths of a second. The mean of both legs'
angles, mirrored, puts the lifted foot down beside the other one, whatever the gait. In a slow step the robot
may be balanced on one foot, and would fall off it; there its joints hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bridge.body.joints import INDEX, LEG_SLOTS
from bridge.messages import SensorFrame

_MIRRORED: Final = tuple(
    (INDEX[f"L{joint}"], INDEX[f"R{joint}"], sign)
    for joint, sign in (
        ("HipRoll", -1.0),
        ("HipPitch", 1.0),
        ("KneePitch", 1.0),
        ("AnklePitch", 1.0),
        ("AnkleRoll", -1.0),
    )
)
"""Slots of both legs' joints, and the sign of the right one's mirror image."""
_LEGS: Final = sorted({slot for slots in LEG_SLOTS.values() for slot in slots})
_FAST: Final = 8.0
"""rad/s of a leg's joint in a step in which no robot can stand still (docs/guard.md)."""
_RECENT: Final = 50
"""Cycles of commands within which one as fast counts: two steps of `omni`."""
_DENSE: Final = 10
"""Commands more than cycles without one that make a stream (assumed)."""
DURATION: Final = 0.15
"""s; a robot tips over with a time constant of 0.16 s (omega = 6.1 /s)."""


class CommandStream:
    """Whether commands came cycle by cycle and moved the legs fast.

    Args:
        cycle: of the robot, s.
    """

    def __init__(self, cycle: float) -> None:
        self._cycle = cycle
        self.reset()

    def reset(self) -> None:
        """No command has come."""
        self._last: Sequence[float] | None = None
        self._count, self._slow = 0, _RECENT

    def update(self, position: Sequence[float] | None) -> None:
        """One cycle.

        Args:
            position: 25, that a command put in force, rad; None: none came, or the robot is not upright.
        """
        if position is None:
            self._count = max(self._count - 1, 0)
            return
        self._count = min(self._count + 1, 2 * _DENSE)
        last = self._last or position
        fastest = max(abs(position[slot] - last[slot]) for slot in _LEGS) / self._cycle
        self._slow = 0 if fastest > _FAST else self._slow + 1
        self._last = position

    @property
    def in_quick_step(self) -> bool:
        """The robot was in a quick step when the newest command came."""
        return self._count >= _DENSE and self._slow < _RECENT


class CloseStance:
    """Both legs to their mirrored mean.

    Args:
        start: 25 positions put out last, rad.
        stiffness: 25, in force; they stay.
        cycle: s
    """

    def __init__(self, start: Sequence[float], stiffness: Sequence[float], cycle: float) -> None:
        goal = np.array(start)
        for left, right, sign in _MIRRORED:
            goal[left] = 0.5 * (start[left] + sign * start[right])
            goal[right] = sign * goal[left]
        self._start, self._goal, self._stiffness = np.array(start), goal, tuple(stiffness)
        self._cycle, self._time = cycle, 0.0
        self.done = False
        """The feet are side by side."""

    def advance(self, _frame: SensorFrame) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and stiffnesses of the next cycle."""
        self._time += self._cycle
        s = min(self._time / DURATION, 1.0)
        self.done = s >= 1.0
        position = self._start + s * s * (3.0 - 2.0 * s) * (self._goal - self._start)
        return tuple(position.tolist()), self._stiffness
