"""Cubic splines that are twice continuously differentiable, and their bases."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.linalg import solve_banded

from bridge.types import Array
from walker.functions import MotionState

Condition = tuple[int, int, float]
"""Place among the breaks, order of the derivative, value."""


class Cubic:
    """A piecewise cubic; outside its breaks the ends' pieces continue.

    Args:
        breaks: n + 1 ascending times, s.
        coefficients: highest power first, from each piece's own beginning, shape (4, n).
    """

    def __init__(self, breaks: Sequence[float] | Array, coefficients: Any) -> None:
        self.breaks = np.asarray(breaks, dtype=np.float64)
        self.coefficients = np.asarray(coefficients, dtype=np.float64)
        self._inner = self.breaks[1:-1].tolist()
        self._starts = self.breaks[:-1].tolist()
        self._pieces = self.coefficients.T.tolist()

    def at(self, t: float) -> MotionState:
        """Position, velocity and acceleration at a time, s."""
        i = bisect_right(self._inner, t)
        a, b, c, d = self._pieces[i]
        s = t - self._starts[i]
        return MotionState(
            ((a * s + b) * s + c) * s + d, (3.0 * a * s + 2.0 * b) * s + c, 6.0 * a * s + 2.0 * b
        )

    def sample(self, times: Array) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration at many times, each of their shape."""
        i = np.searchsorted(self.breaks[1:-1], times, side="right")
        a, b, c, d = self.coefficients[:, i]
        s = times - self.breaks[i]
        return ((a * s + b) * s + c) * s + d, (3.0 * a * s + 2.0 * b) * s + c, 6.0 * a * s + 2.0 * b


def even(first: float, last: float, n: int) -> Array:
    """Evenly spaced numbers, both ends included, shape (n,)."""
    return np.asarray(np.linspace(first, last, n), dtype=np.float64)


def clamped(times: Sequence[float], values: Sequence[float]) -> Cubic:
    """The C2 spline through all knots with zero velocity at both ends ((4) to (6)).

    Args:
        times: knots, s, four or more.
        values: there.
    """
    y = np.asarray(values, dtype=np.float64)
    width = np.diff(np.asarray(times, dtype=np.float64))
    slope = np.diff(y) / width
    # Velocities at the knots from the continuity of the acceleration: a tridiagonal system, by diagonals.
    bands, right = np.zeros((3, len(y))), np.zeros(len(y))
    bands[1] = [1.0, *(2.0 * (width[:-1] + width[1:])), 1.0]
    bands[0, 2:], bands[2, :-2] = width[:-1], width[1:]
    right[1:-1] = 3.0 * (width[1:] * slope[:-1] + width[:-1] * slope[1:])
    velocity = solve_banded((1, 1), bands, right)
    # Hermite form of each piece.
    bend = (velocity[:-1] + velocity[1:] - 2.0 * slope) / width
    return Cubic(times, [bend / width, (slope - velocity[:-1]) / width - bend, velocity[:-1], y[:-1]])


def periodic(times: Sequence[float], values: Sequence[float], *, sign: float = 1.0) -> Cubic:
    """The C2 spline through the knots that repeats itself, with the sign given, after the last of them (9).

    Args:
        times: knots, the last a period after the first, s.
        values: there, the last `sign` times the first.
        sign: 1 periodic, -1 antiperiodic.
    """
    last = len(times) - 1
    conditions: list[Condition] = [(i, 0, value) for i, value in enumerate(values)]
    return _solve(times, conditions, wrap=(last, sign))


def joined(
    times: tuple[float, float, float], start: MotionState, middle: float, end: MotionState, ease: float = 0.2
) -> Cubic:
    """The C2 spline from one full state to another through a point between.

    Two knots without a value of their own, one in each interval, are free to match the accelerations.

    Args:
        times: of start, middle and end, s.
        start: state there.
        middle: position.
        end: state there.
        ease: fraction of an interval, from the outer end, at which its free knot is; a fifth gives a swing
            foot half the acceleration that a half gives.
    """
    t0, t1, t2 = times
    breaks = (t0, t0 + ease * (t1 - t0), t1, t2 - ease * (t2 - t1), t2)
    conditions: list[Condition] = [(0, order, value) for order, value in enumerate(start)]
    conditions += [(4, order, value) for order, value in enumerate(end)]
    conditions.append((2, 0, middle))
    return _solve(breaks, conditions)


def _powers(order: int, s: float) -> list[float]:
    """Row of a derivative of (s^3, s^2, s, 1)."""
    rows = ([s**3, s * s, s, 1.0], [3.0 * s * s, 2.0 * s, 1.0, 0.0], [6.0 * s, 2.0, 0.0, 0.0])
    return rows[order]


def _solve(
    breaks: Sequence[float], conditions: Sequence[Condition], wrap: tuple[int, float] | None = None
) -> Cubic:
    """The C2 piecewise cubic with these conditions; `wrap` ties velocity and acceleration of the ends too.

    Times are scaled to unit length, so that the system is as well conditioned for 0.1 s as for 10 s.
    """
    scale = float(breaks[-1] - breaks[0])
    widths = np.diff(np.asarray(breaks, dtype=np.float64)) / scale
    n = len(widths)
    matrix, right = np.zeros((4 * n, 4 * n)), np.zeros(4 * n)
    row = 0
    for i in range(n - 1):
        for order in range(3):
            matrix[row, 4 * i : 4 * i + 4] = _powers(order, widths[i])
            matrix[row, 4 * i + 4 : 4 * i + 8] = [-x for x in _powers(order, 0.0)]
            row += 1
    for knot, order, value in conditions:
        piece = min(knot, n - 1)
        matrix[row, 4 * piece : 4 * piece + 4] = _powers(order, widths[piece] if knot == n else 0.0)
        right[row] = value * scale**order
        row += 1
    if wrap is not None:
        for order in (1, 2):
            matrix[row, :4] = [wrap[1] * x for x in _powers(order, 0.0)]
            matrix[row, -4:] -= _powers(order, widths[-1])
            row += 1
    solution = np.linalg.solve(matrix, right).reshape(n, 4).T
    return Cubic(breaks, solution / scale ** np.array([[3.0], [2.0], [1.0], [0.0]]))
