"""Path of a joint through given values at given times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.interpolate import CubicHermiteSpline

STEP: Final = 0.020
"""s between two points: the cycle of ALMotion, which writes through the DCM (confirmed: vendor's pages)."""
MAX_POINTS: Final = 400
"""Of one path; a DCM buffer takes 512."""


def smooth(start: float, values: Sequence[float], times: Sequence[float]) -> list[tuple[float, float]]:
    """Points of a smooth path: at rest at both ends, through each value at its time, never beyond them.

    Cubic between the values; slopes at inner values are the harmonic mean of both sides, or 0 at a turn
    (Fritsch and Carlson 1980). Which curve ALMotion takes is not published (assumed).

    Args:
        start: where the joint is at time 0.
        values: to be reached.
        times: when, s, increasing, the first one above 0.

    Returns:
        Pairs of time (s) and value, the last one exactly the last value.
    """
    t = np.array([0.0, *times])
    y = np.array([start, *values])
    chord = np.diff(y) / np.diff(t)
    slope = np.zeros_like(y)
    left, right = chord[:-1], chord[1:]
    same = left * right > 0.0
    slope[1:-1][same] = 2.0 * left[same] * right[same] / (left[same] + right[same])
    curve = CubicHermiteSpline(t, y, slope)
    count = max(1, min(MAX_POINTS, round(t[-1] / STEP)))
    at = np.linspace(0.0, t[-1], count + 1)[1:]
    points = [(float(moment), float(value)) for moment, value in zip(at, curve(at), strict=True)]
    points[-1] = (float(t[-1]), float(y[-1]))
    return points
