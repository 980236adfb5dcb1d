"""Magnetic absolute encoders on the joints."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


class Encoders:
    """Rounds joint angles to the encoder's grid.

    Args:
        steps: Counts per turn (data sheet: 12 bit; the grid 2 pi / 4096 is confirmed by captured V6 packets).
    """

    def __init__(self, steps: int) -> None:
        self._step = 2.0 * math.pi / steps

    def read(self, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """Measured angles of true ones, rad."""
        return np.asarray(np.rint(angles / self._step) * self._step)
