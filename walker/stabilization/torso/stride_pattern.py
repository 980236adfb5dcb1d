"""The lean that each stride repeats: what alternates between the feet at the same part of their steps.

In walking to a side or in a turn the torso leans one way on the left foot and the other way on the right one.
That is no disturbance, and an ankle that turned against it, late as it is, would amplify it. A lean that both
feet have in common, as over an edge, is no part of the pattern.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bridge.types import Array, Side, Vec2
from walker.planning.plan import OTHER_SIDE

_PARTS: Final = 8
"""Of a step, each with a pattern of its own."""


class StridePattern:
    """Lean in, lean less the alternating pattern out, once per DCM cycle of single support.

    Args:
        gain: share of the lean that goes to the mean of its part of a step in a cycle, 0..1.
    """

    def __init__(self, gain: float) -> None:
        self._gain = gain
        self._means: dict[Side, Array] = {"L": np.zeros((_PARTS, 2)), "R": np.zeros((_PARTS, 2))}
        """Roll and pitch by the standing foot and the part of its step, rad."""

    def without(self, lean: Vec2, support: Side, progress: float) -> Vec2:
        """The lean less half the difference of both feet's means, rad.

        Args:
            lean: roll and pitch of the torso, rad.
            support: the foot that stands.
            progress: fraction of its step that has passed, 0..1.
        """
        part = min(int(progress * _PARTS), _PARTS - 1)
        mean, other = self._means[support][part], self._means[OTHER_SIDE[support]][part]
        mean += self._gain * (lean - mean)
        roll, pitch = lean - 0.5 * (mean - other)
        return float(roll), float(pitch)
