"""Refinement of a hip motion: all four numbers together, between the points of the grids."""

from __future__ import annotations

import warnings
from typing import Final

import numpy as np
from scipy.optimize import minimize

from bridge.types import Array
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.motions import Linear, sample_x, sample_y
from nao_hil.design.huang.table import ZmpTable
from walker.gaits.huang.hip import Choice
from walker.gaits.huang.parameters import HuangParameters
from walker.gaits.huang.spline import even

MEAN_WEIGHT: Final = 0.02
"""Weight of the mean margin over the cycle beside the minimum. The minimum has flat tops, of which the mean
picks a point; it costs less than 0.05 mm of the minimum."""


def grids(p: HuangParameters, n: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Grids of x_sd, x_ed and of y_d, y_m. A named number is one point. Bound (11) itself is not admissible.

    Args:
        p: parameters.
        n: points along each dimension.

    Returns:
        The grids of x_sd and x_ed, and those of y_d and y_m, m.
    """
    along = np.arange(1, n + 1) / (n + 1) * 0.5 * p.D_s
    half = 0.5 * p.l_FA
    searched = (along, along, even(-0.2, 0.6, n) * half, even(0.2, 1.0, n) * half)
    named = (p.x_sd, p.x_ed, p.y_d, p.y_m)
    x_sd, x_ed, y_d, y_m = (
        grid if value is None else np.array([value]) for grid, value in zip(searched, named, strict=True)
    )
    return (x_sd, x_ed), (y_d, y_m)


def tabulated(cycle: Cycle, choice: Choice, axis: str, motions: Linear, axes: tuple[Array, Array]) -> ZmpTable:
    """Factors of (13), (14) over the range of two grids.

    Args:
        cycle: body and parameters.
        choice: for the other axis.
        axis: `x` or `y`.
        motions: along the axis.
        axes: both grids, m.
    """
    corners = np.array([(i, j) for i in axes[0][[0, -1]] for j in axes[1][[0, -1]]]).T
    return cycle.table(choice, axis, motions, (corners[0], corners[1]))


def refined(cycle: Cycle, choice: Choice, grid: int) -> Choice:
    """A choice of all four numbers with no less margin, by sequential quadratic programming.

    It maximises the m that no moment's margin is less than. x of the ZMP is tabulated at the choice's y, and y
    at its x.

    Args:
        cycle: body and parameters.
        choice: to begin from.
        grid: points along each dimension, whose first and last are the limits.
    """
    p = cycle.p
    pairs = grids(p, grid)
    motions = sample_x(p, cycle.times), sample_y(p, cycle.times)
    tables = (
        tabulated(cycle, choice, "x", motions[0], pairs[0]),
        tabulated(cycle, choice, "y", motions[1], pairs[1]),
    )
    limits = [(float(axis[0]), float(axis[-1])) for pair in pairs for axis in pair]

    def margins(choices: Array) -> Array:
        """Of all moments, shape (times, choices), from choices of shape (choices, 4)."""
        x, _ = tables[0].zmp(motions[0].at(choices[:, 0], choices[:, 1]))
        _, y = tables[1].zmp(motions[1].at(choices[:, 2], choices[:, 3]))
        return cycle.support.margins(x, y)

    # Unknowns v: the four numbers and m, all in mm, so that steps and tolerances of the method fit.
    def room(v: Array) -> Array:
        left: Array = 1e3 * margins(1e-3 * v[None, :4])[:, 0] - v[4]
        return left

    def slopes(v: Array) -> Array:
        step = 1e-3
        moved = 1e-3 * (v[:4] + step * np.vstack((np.eye(4), -np.eye(4))))
        found = 1e3 * margins(moved)
        by_choice = (found[:, :4] - found[:, 4:]) / (2.0 * step)
        return np.column_stack((by_choice, np.full(len(by_choice), -1.0)))

    def cost(v: Array) -> float:
        return -float(v[4] + MEAN_WEIGHT * (room(v) + v[4]).mean())

    def steepest(v: Array) -> Array:
        return -np.append(MEAN_WEIGHT * slopes(v)[:, :4].mean(axis=0), 1.0)

    start = np.array(choice)
    begin = np.append(1e3 * start, 1e3 * float(margins(start[None]).min()))
    with warnings.catch_warnings():
        # Its steps leave the bounds by a rounding error.
        warnings.filterwarnings("ignore", "Values in x were outside bounds")
        found = minimize(
            cost,
            begin,
            jac=steepest,
            method="SLSQP",
            bounds=[(1e3 * low, 1e3 * high) for low, high in limits] + [(None, None)],
            constraints={"type": "ineq", "fun": room, "jac": slopes},
            options={"maxiter": 100, "ftol": 1e-6},
        )
    better = np.clip(1e-3 * found.x[:4], *np.array(limits).T)
    reached = np.append(1e3 * better, 1e3 * float(margins(better[None]).min()))
    return Choice(*better.tolist()) if cost(reached) < cost(begin) else choice
