"""Readings of an accelerometer or a gyroscope for a true vector."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bridge.types import Vec3
from emulator.compiled import compilable
from emulator.sensors.noise import NormalRows
from emulator.sensors.parameters import TriaxialParameters

Vector = NDArray[np.float64]
Constants = tuple[Vector, float, float]
ALL_AXES: Final = 3
_QUIET: Final = np.zeros(0)


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
        self.gain: Vector = (1.0 + p.gain * constants.standard_normal(3)) * present
        """Reading per true value; 0 for an axis that is not there."""
        self.bias: Vector = p.bias * constants.standard_normal(3) * present
        """In the sensor's unit."""
        self._rows = NormalRows(noise, 3) if p.noise > 0.0 else None
        top = max_value if p.saturation else math.inf
        step = step if p.quantisation else 0.0
        self.constants: Constants = (np.array([self.gain, self.bias, p.noise * present]), top, step)
        """For `measured`; the step, the last, for `reported`."""

    def noise(self) -> Vector:
        """Of the next sample, for `measured`."""
        return _QUIET if self._rows is None else self._rows.next()

    def measure(self, true: Vec3) -> Vec3:
        """One sample of a true vector, not yet rounded."""
        return measured(true, self.constants, self.noise())


@compilable
def measured(true: Vec3, constants: Constants, noise: Vector) -> Vec3:
    """One sample of a true vector, not yet rounded.

    Args:
        true: In the sensor's unit.
        constants: `TriaxialSensor.constants`: rows of gain, bias and deviation of the noise; range; step.
        noise: Standard normal, (3,); none: (0,).
    """
    axes, top, _ = constants
    x, y, z = true[0] * axes[0, 0], true[1] * axes[0, 1], true[2] * axes[0, 2]
    x, y, z = x + axes[1, 0], y + axes[1, 1], z + axes[1, 2]
    if len(noise) > 0:
        x, y, z = x + axes[2, 0] * noise[0], y + axes[2, 1] * noise[1], z + axes[2, 2] * noise[2]
    return max(-top, min(x, top)), max(-top, min(y, top)), max(-top, min(z, top))


@compilable
def reported(sample: Vec3, step: float) -> Vec3:
    """A sample in whole steps.

    Args:
        sample: In the sensor's unit.
        step: 0: as it is.
    """
    if step == 0.0:
        return sample
    return round(sample[0] / step) * step, round(sample[1] / step) * step, round(sample[2] / step) * step
