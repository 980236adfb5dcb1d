"""Readings of the eight force cells for the forces on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from emulator.sensors.noise import NormalRows
from emulator.sensors.parameters import FsrParameters

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
        constants, drift, noise = random.spawn(3)
        p = parameters
        self.gain: list[float] = (1.0 + p.gain * constants.standard_normal(CELLS)).tolist()
        """Reading per force, cell by cell."""
        self.offset: list[float] = (p.offset * constants.standard_normal(CELLS)).tolist()
        """N"""
        self._max_force = max_force if p.saturation else math.inf
        self._step, self._dead_band, self._noise = p.step, p.dead_band, p.noise
        self._drifts, self._noises = NormalRows(drift, CELLS), NormalRows(noise, CELLS)
        self._drift_decay = math.exp(-cycle / p.drift_time)
        self._drift_step = p.drift * math.sqrt(1.0 - self._drift_decay**2)
        self.drift: list[float] = [p.drift * n for n in self._drifts.next()]
        """What the offsets have wandered to, N."""

    def read(self, forces: Sequence[float]) -> tuple[float, ...]:
        """Readings of all cells for the forces on them, N; once per cycle."""
        if self._drift_step > 0.0:
            self.drift = [
                d * self._drift_decay + self._drift_step * n
                for d, n in zip(self.drift, self._drifts.next(), strict=True)
            ]
        readings = [
            (force if force >= self._dead_band else 0.0) * gain + offset + drift
            for force, gain, offset, drift in zip(forces, self.gain, self.offset, self.drift, strict=True)
        ]
        if self._noise > 0.0:
            readings = [r + self._noise * n for r, n in zip(readings, self._noises.next(), strict=True)]
        if self._step > 0.0:
            readings = [round(r / self._step) * self._step for r in readings]
        # a cell can be pressed only
        return tuple(min(max(r, 0.0), self._max_force) for r in readings)
