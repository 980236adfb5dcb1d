"""Errors of the walker: targets that no leg can reach, and quantities that a state does not define."""

from __future__ import annotations

from typing import ClassVar

from bridge.errors import NaoHilError
from bridge.types import Side


class UnreachableError(NaoHilError):
    """A foot target that the leg cannot reach with any angles, limits left aside.

    Attributes:
        side: The leg.
        distance: How far the target is out of reach, m (infinite for a target that is not a number).
    """

    exit_code: ClassVar[int] = 3

    def __init__(self, side: Side, distance: float, sentence: str) -> None:
        super().__init__(sentence)
        self.side = side
        self.distance = distance
