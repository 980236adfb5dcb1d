"""Readings of an accelerometer or a gyroscope for a true vector."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from bridge.types import Vec3
from emulator.sensors.noise import NormalRows
from emulator.sensors.parameters import TriaxialParameters

ALL_AXES: Final = 3


class TriaxialSensor:
    """Gain, bias, noise, range; quantised when reported.

    The board that fuses the angle is taken to see the samples before they are rounded for the bus: it samples
    faster than the DCM and averages (assumed; its vendor publishes nothing).

    Args:
        max_value: Range (data sheet).
        step: Of the reported values (data sheet).
        axes: 3, or 2 without a Z axis.
        parameters: Imperfections.
        random: A generator of its own.
    """

    def __init__(
        self,
        max_value: float,
        step: float,
        axes: int,
        parameters: TriaxialParameters,
        random: np.random.Generator,
    ) -> None:
        constants, noise = random.spawn(2)
        p = parameters
        present = np.array([1.0, 1.0, 1.0 if axes == ALL_AXES else 0.0])
        self.gain: list[float] = ((1.0 + p.gain * constants.standard_normal(3)) * present).tolist()
        """Reading per true value; 0 for an axis that is not there."""
        self.bias: list[float] = (p.bias * constants.standard_normal(3) * present).tolist()
        """In the sensor's unit."""
        self._noise: list[float] = (p.noise * present).tolist()
        self._noisy = p.noise > 0.0
        self._rows = NormalRows(noise, 3)
        self._max_value = max_value if p.saturation else math.inf
        self._step = step if p.quantisation else 0.0

    def measure(self, true: Vec3) -> Vec3:
        """One sample of a true vector, not yet rounded."""
        g, b, top = self.gain, self.bias, self._max_value
        x, y, z = true[0] * g[0] + b[0], true[1] * g[1] + b[1], true[2] * g[2] + b[2]
        if self._noisy:
            n, s = self._rows.next().tolist(), self._noise
            x, y, z = x + s[0] * n[0], y + s[1] * n[1], z + s[2] * n[2]
        return max(-top, min(x, top)), max(-top, min(y, top)), max(-top, min(z, top))

    def report(self, sample: Vec3) -> Vec3:
        """The sample in whole steps."""
        step = self._step
        if step == 0.0:
            return sample
        return round(sample[0] / step) * step, round(sample[1] / step) * step, round(sample[2] / step) * step
