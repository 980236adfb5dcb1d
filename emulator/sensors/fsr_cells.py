"""Readings of the eight force cells for the forces on them."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from emulator.compiled import compiled
from emulator.sensors.noise import NormalRows
from emulator.sensors.parameters import FsrParameters

Vector = NDArray[np.float64]
CELLS: Final = 8


class ForceCells:
    """Dead band, gain, offset, drift, noise, range and quantisation, in this order.

    The drift of each cell is a first-order Gauss-Markov process that has been going on before the start.

    Args:
        max_force: Range of a cell, N (data sheet).
        cycle: Time between two readings, s.
        parameters: Imperfections.
        random: A generator of their own.
    """

    def __init__(
        self, max_force: float, cycle: float, parameters: FsrParameters, random: np.random.Generator
    ) -> None:
        constants, drift, noise, common = random.spawn(4)
        p = parameters
        self.gain: Vector = (1.0 + p.common_gain * common.standard_normal()) * (
            1.0 + p.gain * constants.standard_normal(CELLS)
        )
        """Reading per force, cell by cell."""
        self.offset: Vector = p.offset * constants.standard_normal(CELLS)
        """N"""
        self._max_force = max_force if p.saturation else math.inf
        self._step, self._dead_band, self._noise = p.step, p.dead_band, p.noise
        self._drifts, self._noises = NormalRows(drift, CELLS), NormalRows(noise, CELLS)
        self._drift_decay = math.exp(-cycle / p.drift_time)
        self._drift_step = p.drift * math.sqrt(1.0 - self._drift_decay**2)
        self.drift: Vector = p.drift * self._drifts.next()
        """What the offsets have wandered to, N."""

    def read(self, forces: Vector) -> tuple[float, ...]:
        """Readings of all cells for the forces on them, (8,), N; once per cycle."""
        self.drift, readings = _read(
            forces,
            self._dead_band,
            self.gain,
            self.offset,
            self.drift,
            self._drift_decay,
            self._drift_step,
            self._drifts.next(),
            self._noise,
            self._noises.next(),
            self._step,
            self._max_force,
        )
        return tuple(readings.tolist())


@compiled
def _read(
    forces: Vector,
    dead_band: float,
    gain: Vector,
    offset: Vector,
    before: Vector,
    drift_decay: float,
    drift_step: float,
    wander: Vector,
    deviation: float,
    noise: Vector,
    step: float,
    max_force: float,
) -> tuple[Vector, Vector]:
    """The drift after a cycle, and the readings with it."""
    drift, readings = np.empty(CELLS), np.empty(CELLS)
    for i in range(CELLS):
        drift[i] = before[i] * drift_decay + drift_step * wander[i]
        felt = forces[i] if forces[i] >= dead_band else 0.0
        reading = felt * gain[i] + offset[i] + drift[i] + deviation * noise[i]
        if step > 0.0:
            reading = round(reading / step) * step
        # a cell can be pressed only
        readings[i] = min(max(reading, 0.0), max_force)
    return drift, readings
