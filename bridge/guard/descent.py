"""The descent: from any stand to a crouch at limited speed, then a ramp of the stiffness to its rest value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bridge.body.joints import LEG_SLOTS, N_JOINTS
from bridge.guard.config import CrouchSettings
from bridge.messages import SensorFrame

_PEAK: Final = 1.875
"""Peak over mean speed of a motion that begins and ends at rest without a jump of acceleration (quintic)."""
_MIN_DURATION: Final = 0.5
"""s"""
_LEGS: Final = frozenset(slot for slots in LEG_SLOTS.values() for slot in slots)


class Descent:
    """Rest to rest in joint space, then a pause, then the ramp of the stiffness.

    Args:
        start: 25 positions put out last, rad.
        stiffness: 25, as they are in force; what is free stays free.
        goal: the crouch, 25 positions.
        settings: speeds and times.
        cycle: s
        moving: False: only the ramp, where the robot is.
        standing: the legs keep `rest_stiffness`, without which a crouched robot may tip over; False: none.
    """

    def __init__(
        self,
        start: Sequence[float],
        stiffness: Sequence[float],
        goal: Sequence[float],
        settings: CrouchSettings,
        cycle: float,
        *,
        moving: bool,
        standing: bool,
    ) -> None:
        self._start, self._goal = np.array(start), np.array(goal if moving else start)
        self._stiffness = np.array(stiffness)
        rest = [settings.rest_stiffness if standing and i in _LEGS else 0.0 for i in range(N_JOINTS)]
        self._rest = np.minimum(self._stiffness, rest)
        way = float(np.abs(self._goal - self._start).max())
        self._duration = (
            max(_PEAK * way / settings.speed, _MIN_DURATION) + settings.settle_time if moving else 0.0
        )
        self._moving = self._duration - settings.settle_time
        self._release_time, self._cycle, self._time = settings.release_time, cycle, 0.0
        self.done = False
        """The stiffness is down."""

    def advance(self, _frame: SensorFrame) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Positions and stiffnesses of the next cycle."""
        self._time += self._cycle
        s = min(self._time / self._moving, 1.0) if self._moving > 0.0 else 1.0
        blend = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        position = self._start + blend * (self._goal - self._start)
        released = min(max((self._time - self._duration) / max(self._release_time, self._cycle), 0.0), 1.0)
        self.done = released >= 1.0
        ramp = self._stiffness + released * (self._rest - self._stiffness)
        stiffness = self._rest if self.done else ramp
        return tuple(position.tolist()), tuple(stiffness.tolist())
