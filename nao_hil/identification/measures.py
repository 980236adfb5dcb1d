"""Measures of a joint's tracking: error, delay and hysteresis; spectra of sensors."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.signal import welch

from bridge.types import Array

LONGEST_DELAY: Final = 0.2
"""Longest delay that is looked for, s."""
_MIN_MOTION: Final = 0.01
"""Standard deviation of a command from which on the joint counts as moved, rad."""
_SLOW_SPEEDS: Final = (0.02, 0.5)
"""Speeds of the command at which hysteresis is measured, rad/s."""
_BINS: Final = 24
_MIN_PER_BIN: Final = 3
"""Samples that a bin needs of each direction."""
_SEGMENT: Final = 256


def rms(values: Array) -> float:
    """Root of the mean square; NaN left out."""
    return float(np.sqrt(np.nanmean(np.square(values))))


def vertex(values: Array, best: int) -> float:
    """Place of an extremum between samples: of the parabola through three of them.

    Args:
        values: (n,)
        best: Index of the largest or the smallest; at an end it is the place itself.
    """
    if not 0 < best < len(values) - 1:
        return float(best)
    before, at, after = values[best - 1 : best + 2]
    return float(best + 0.5 * (before - after) / (before - 2.0 * at + after))


def tracking_error(command: Array, position: Array) -> float:
    """RMS of the angle less the command of its cycle, rad; both (n,)."""
    return rms(position - command)


def delay(command: Array, position: Array, cycle: float) -> float | None:
    """Time by which a joint follows its command, s: where speeds of command and joint correlate best.

    Args:
        command: Angle asked for, (n,), rad.
        position: Angle measured at the beginning of the same cycle, (n,), rad.
        cycle: s

    Returns:
        The peak of the cross-correlation, by a parabola through its three highest values; None: the command
        does not move, or nothing follows it.
    """
    asked, moved = np.diff(command), np.diff(position)
    if not np.isfinite(asked).all() or not np.isfinite(moved).all() or np.std(command) < _MIN_MOTION:
        return None
    lags = range(min(round(LONGEST_DELAY / cycle), len(asked) // 2) + 1)
    product = np.array([float(np.dot(asked[: len(asked) - lag], moved[lag:])) for lag in lags])
    best = int(np.argmax(product))
    if product[best] <= 0.0 or best in (0, len(product) - 1):
        return None
    return vertex(product, best) * cycle


def hysteresis(command: Array, position: Array, cycle: float, lag: float) -> float | None:
    """Width of the loop of angle over command in slow motion, rad.

    At each command, the median angle of the falling branch less that of the rising one; of these differences,
    the 90th percentile, because backlash shows only where the load changes its sign.

    Args:
        command: (n,), rad.
        position: (n,), rad.
        cycle: s
        lag: Delay by which the command is shifted first, s.

    Returns:
        None where the command does not move slowly to and fro over the same angles.
    """
    time = np.arange(len(command)) * cycle
    shifted = np.interp(time - lag, time, command)
    speed = np.gradient(shifted, cycle)
    slow = (np.abs(speed) > _SLOW_SPEEDS[0]) & (np.abs(speed) < _SLOW_SPEEDS[1]) & np.isfinite(position)
    if slow.sum() < 2 * _MIN_PER_BIN:
        return None
    edges = np.linspace(shifted[slow].min(), shifted[slow].max(), _BINS + 1)
    place = np.digitize(shifted, edges[1:-1])
    widths = []
    for number in range(_BINS):
        here = slow & (place == number)
        rising, falling = here & (speed > 0.0), here & (speed < 0.0)
        if min(rising.sum(), falling.sum()) >= _MIN_PER_BIN:
            error = position - shifted
            widths.append(float(np.median(error[falling]) - np.median(error[rising])))
    return float(np.percentile(widths, 90)) if widths else None


def spectrum(values: Array, cycle: float) -> tuple[Array, Array]:
    """Power spectral density by Welch's method, mean taken out.

    Args:
        values: (n,)
        cycle: s

    Returns:
        Frequencies in Hz and densities in units^2/Hz.
    """
    frequency, density = welch(values, fs=1.0 / cycle, nperseg=min(_SEGMENT, len(values)))
    return np.asarray(frequency), np.asarray(density)
