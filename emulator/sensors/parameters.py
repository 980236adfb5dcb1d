"""Imperfections of the sensors: one number or switch per effect, every default ideal; noise.

Constants of a robot (gains, biases, offsets) are drawn once per run from a normal distribution with the given
standard deviation; noise is drawn for each sample.
"""

from __future__ import annotations

from typing import Annotated, Final

import msgspec
import numpy as np

from bridge.types import Array

BLOCK: Final = 256
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Positive = Annotated[float, msgspec.Meta(gt=0.0)]


class NormalRows:
    """Rows of independent standard normal numbers from a generator of their own.

    Args:
        random: Used by nothing else, so that other draws change nothing here.
        width: Numbers per row.
    """

    def __init__(self, random: np.random.Generator, width: int) -> None:
        self._random, self._width = random, width
        self._left = 0

    def next(self) -> Array:
        """The next row, (width,)."""
        if self._left == 0:
            self._rows, self._left = self._random.standard_normal((BLOCK, self._width)), BLOCK
        self._left -= 1
        row: Array = self._rows[self._left]
        return row


class _Parameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base: frozen, and a misspelt key is an error."""


class EncoderParameters(_Parameters, frozen=True):
    """Joint encoders."""

    grid: bool = True
    """Round to the data sheet's counts per turn; a property of the part, so an ideal robot has it too."""
    residue: NotNegative = 0.0
    """Offset of each joint's grid from whole counts, rad; the sign is drawn per joint."""
    zero_error: NotNegative = 0.0
    """Standard deviation of the joints' zero errors, rad."""
    noise: NotNegative = 0.0
    """Standard deviation per sample, rad."""


class FsrParameters(_Parameters, frozen=True):
    """Force sensors of the feet, per cell."""

    saturation: bool = False
    """Nothing above the data sheet's range."""
    step: NotNegative = 0.0
    """Quantisation, N; 0: none."""
    common_gain: NotNegative = 0.0
    """Standard deviation of the gain around 1 that all cells of a robot share."""
    gain: NotNegative = 0.0
    """Standard deviation of each cell's gain around that."""
    offset: NotNegative = 0.0
    """Standard deviation of the cells' offsets, N."""
    drift: NotNegative = 0.0
    """Standard deviation of the slow wandering of each cell's offset, N."""
    drift_time: Positive = 60.0
    """Correlation time of the wandering, s."""
    dead_band: NotNegative = 0.0
    """Forces below are not felt, N."""
    noise: NotNegative = 0.0
    """Standard deviation per sample, N."""


class TriaxialParameters(_Parameters, frozen=True):
    """Accelerometer (m/s^2) or gyroscope (rad/s), per axis."""

    saturation: bool = False
    """Nothing beyond the data sheet's range."""
    quantisation: bool = False
    """Report multiples of the data sheet's step."""
    gain: NotNegative = 0.0
    """Standard deviation of the axes' gains around 1."""
    bias: NotNegative = 0.0
    """Standard deviation of the axes' biases."""
    noise: NotNegative = 0.0
    """Standard deviation per sample."""


class FusedAngleParameters(_Parameters, frozen=True):
    """Filter that fuses the torso's angle; see `emulator.sensors.fusion`."""

    motion_time: Positive = 20.0
    """Time constant with which the accelerometer pulls the angle while the rate changes, s."""
    rest_time: Positive = 0.05
    """The same while the rate is steady, s."""
    rest_rate: NotNegative = 0.0
    """Largest standard deviation of a steady rate, rad/s; 0: the filter never switches."""


class SonarParameters(_Parameters, frozen=True):
    """Ultrasound in the chest."""

    step: NotNegative = 0.0
    """Quantisation, m; 0: none."""
    noise: NotNegative = 0.0
    """Standard deviation per echo, m."""


class BatteryParameters(_Parameters, frozen=True):
    """Battery in the torso."""

    capacity: NotNegative = 0.0
    """Fraction of the data sheet's energy that it still holds; 0: it never runs down."""
    voltage: Positive = 21.6
    """V, taken as constant."""
    charge: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 1.0
    """At the start."""
    idle_current: NotNegative = 0.0
    """Current of the computers, A."""
    heating: NotNegative = 0.0
    """Temperature over the room's in the end, K per A^2."""
    heating_time: Positive = 900.0
    """Time constant of the heating, s."""
    room: float = 25.0
    """Temperature at the start, degrees Celsius."""


class SensorParameters(_Parameters, frozen=True):
    """Imperfections of all sensors."""

    encoders: EncoderParameters = EncoderParameters()
    fsr: FsrParameters = FsrParameters()
    accelerometer: TriaxialParameters = TriaxialParameters()
    gyroscope: TriaxialParameters = TriaxialParameters()
    fused_angle: FusedAngleParameters = FusedAngleParameters()
    sonar: SonarParameters = SonarParameters()
    battery: BatteryParameters = BatteryParameters()
