"""Roots of functions of one variable."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

_RELATIVE: Final = 4.0 * 2.0**-52
"""Relative tolerance: four units in the last place."""
_MAX_ITERATIONS: Final = 100


def brent(function: Callable[[float], float], low: float, high: float, tolerance: float) -> float:
    """Root of a continuous function between two points of opposite sign, by Brent's method.

    The same steps as `scipy.optimize.brentq`, without loading SciPy's optimisers into the walker.

    Args:
        function: negative at one end and positive at the other.
        low: one end.
        high: other end.
        tolerance: absolute, of the root.
    """
    previous, current = low, high
    at_previous, at_current = function(previous), function(current)
    opposite, at_opposite, step, last_step = previous, at_previous, current - previous, current - previous
    for _ in range(_MAX_ITERATIONS):
        if at_previous != 0.0 and (at_previous < 0.0) != (at_current < 0.0):
            opposite, at_opposite = previous, at_previous
            last_step = step = current - previous
        if abs(at_opposite) < abs(at_current):
            previous, current, opposite = current, opposite, current
            at_previous, at_current, at_opposite = at_current, at_opposite, at_current
        delta = 0.5 * (tolerance + _RELATIVE * abs(current))
        middle = 0.5 * (opposite - current)
        if at_current == 0.0 or abs(middle) < delta:
            break
        trial = 0.0
        if abs(last_step) > delta and abs(at_current) < abs(at_previous):
            if previous == opposite:  # secant
                trial = -at_current * (current - previous) / (at_current - at_previous)
            else:  # inverse quadratic interpolation
                to_previous = (at_previous - at_current) / (previous - current)
                to_opposite = (at_opposite - at_current) / (opposite - current)
                trial = (
                    -at_current
                    * (at_opposite * to_opposite - at_previous * to_previous)
                    / (to_opposite * to_previous * (at_opposite - at_previous))
                )
            good = 2.0 * abs(trial) < min(abs(last_step), 3.0 * abs(middle) - delta)
        else:
            good = False
        last_step, step = (step, trial) if good else (middle, middle)
        previous, at_previous = current, at_current
        current += step if abs(step) > delta else (delta if middle > 0.0 else -delta)
        at_current = function(current)
    return current
