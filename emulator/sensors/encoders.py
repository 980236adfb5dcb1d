"""Magnetic absolute encoders on the joints."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from emulator.compiled import compiled
from emulator.sensors.noise import NormalRows
from emulator.sensors.parameters import EncoderParameters

Vector = NDArray[np.float64]


class Encoders:
    """What the encoders of all joints read.

    Captured V6 packets lie on a grid of 2 pi / 4096 that is off whole counts by the same amount on every joint,
    with a sign that is the joint's own: the grid is shifted, the reading stays true to half a step.

    Args:
        steps: Counts per turn (data sheet).
        count: Number of joints.
        parameters: Imperfections.
        random: A generator of their own.
    """

    def __init__(
        self, steps: int, count: int, parameters: EncoderParameters, random: np.random.Generator
    ) -> None:
        constants, noise = random.spawn(2)
        self._step = 2.0 * math.pi / steps if parameters.grid else 0.0
        self.shift: Vector = np.where(constants.random(count) < 0.5, -1.0, 1.0) * parameters.residue
        """Place of each joint's grid, rad."""
        self.zero_error: Vector = constants.standard_normal(count) * parameters.zero_error
        """What each joint reads too much, rad."""
        self._noise = parameters.noise
        self._rows = NormalRows(noise, count)

    def read(self, angles: Vector) -> Vector:
        """Measured angles of true ones, rad."""
        return _read(angles, self.zero_error, self._noise, self._rows.next(), self.shift, self._step)


@compiled
def _read(
    angles: Vector, zero_error: Vector, deviation: float, noise: Vector, shift: Vector, step: float
) -> Vector:
    read = np.empty_like(angles)
    for i in range(len(angles)):
        read[i] = angles[i] + zero_error[i] + noise[i] * deviation
        if step > 0.0:
            read[i] = np.rint((read[i] - shift[i]) / step) * step + shift[i]
    return read
