"""Standard normal numbers in rows, drawn in blocks: one call per sample would cost more than the sensor."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
BLOCK: Final = 256


class NormalRows:
    """Rows of independent standard normal numbers from a generator of their own.

    Args:
        random: Used by nothing else, so that other draws change nothing here.
        width: Numbers per row.
    """

    def __init__(self, random: np.random.Generator, width: int) -> None:
        self._random, self._width = random, width
        self._left = 0

    def next(self) -> Vector:
        """The next row, (width,)."""
        if self._left == 0:
            self._rows, self._left = self._random.standard_normal((BLOCK, self._width)), BLOCK
        self._left -= 1
        row: Vector = self._rows[self._left]
        return row
