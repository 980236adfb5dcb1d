"""Knowledge of the ground before a walk: plain data for a planner.

Its source is open: a scenario's file, a measurement, a map.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec

from bridge.types import Vec2


class Patch(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A level rectangle that lies higher than the floor about it."""

    x: Vec2
    """From, to, along the walk, m from the place between the feet at the start."""
    y: Vec2
    """From, to, to the left, m."""
    height: float
    """Above the floor, m."""


class KnownGround(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A floor with one slope along the walk, and level patches on it."""

    slope: Annotated[float, msgspec.Meta(gt=-0.6, lt=0.6)] = 0.0
    """Angle of the floor about y, rad, positive: downhill."""
    patches: tuple[Patch, ...] = ()

    @property
    def flat(self) -> bool:
        """Whether there is neither slope nor patch."""
        return self.slope == 0.0 and not self.patches

    def stretched(self, factor: float) -> KnownGround:
        """The same ground with all places along the walk times a factor, for a walk with other metres."""
        patches = tuple(
            msgspec.structs.replace(patch, x=(factor * patch.x[0], factor * patch.x[1]))
            for patch in self.patches
        )
        return msgspec.structs.replace(self, patches=patches)

    def edges(self) -> tuple[float, ...]:
        """Places along the walk at which the height jumps, m."""
        return tuple(sorted({x for patch in self.patches for x in patch.x}))

    def at(self, x: float, sides: Sequence[float]) -> float:
        """Height of the ground at a place along the walk above that at x = 0 of the floor, slope included, m.

        Args:
            x: m.
            sides: places to the left to look at, m.
        """
        return self.height(x, sides) - math.tan(self.slope) * x

    def height(self, x: float, sides: Sequence[float]) -> float:
        """Height of the highest patch at a place along the walk, above the floor, m.

        Args:
            x: m.
            sides: places to the left to look at, m.
        """
        return max(
            (
                patch.height
                for patch in self.patches
                for y in sides
                if patch.x[0] <= x <= patch.x[1] and patch.y[0] <= y <= patch.y[1]
            ),
            default=0.0,
        )
