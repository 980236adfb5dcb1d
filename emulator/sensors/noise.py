"""Standard normal numbers in rows, drawn in blocks: one call per sample would cost more than the sensor."""

from __future__ import annotations

from typing import Final

import numpy as np

BLOCK: Final = 256


class NormalRows:
    """Rows of independent standard normal numbers from a generator of their own.

    Args:
        random: Used by nothing else, so that other draws change nothing here.
        width: Numbers per row.
    """

    def __init__(self, random: np.random.Generator, width: int) -> None:
        self._random, self._width = random, width
        self._rows: list[list[float]] = []

    def next(self) -> list[float]:
        """The next row."""
        if not self._rows:
            self._rows = self._random.standard_normal((BLOCK, self._width)).tolist()
        return self._rows.pop()
