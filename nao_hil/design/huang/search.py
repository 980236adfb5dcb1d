"""The search for the motion of the hip with the largest stability margin ((11), (12)).

The source tries all x_sd, x_ed in (0, 0.5 D_s). So does this search, all pairs over the whole cycle at once,
and the same for y_d, y_m, which the source does not have. The two searches take turns, because the polygon of a
double support couples x and y: each pair alone stops where the minimum margin has a ridge across them. From
there all four are refined together.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Final, NamedTuple

import msgspec
import numpy as np
from scipy.optimize import minimize

from bridge.errors import ConfigurationError
from bridge.types import Array
from nao_hil.design.huang.cycle import Cycle
from nao_hil.design.huang.motions import Linear, Sampled, sample_x, sample_y
from nao_hil.design.huang.table import ZmpTable
from walker.gaits.catalogue import check_walkable
from walker.gaits.huang import HuangGait
from walker.gaits.huang.hip import Choice
from walker.gaits.huang.parameters import HuangParameters
from walker.gaits.huang.spline import even

MEAN_WEIGHT: Final = 0.02
"""Weight of the mean margin over the cycle against the minimum. The minimum has flat tops, of which the mean
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

    It maximises the m that no moment's margin is less than. Each table moves both coordinates of the ZMP, one
    pair at a time; the changes by the two pairs add up, which is exact where one pair moves alone.

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

    def moved(choices: Array) -> tuple[Array, Array]:
        """ZMP by each table, shapes (x y, times, choices), from choices of shape (choices, 4)."""
        by_x = np.array(tables[0].zmp(motions[0].at(choices[:, 0], choices[:, 1])))
        return by_x, np.array(tables[1].zmp(motions[1].at(choices[:, 2], choices[:, 3])))

    start = np.array(choice)
    middle = 0.5 * sum(moved(start[None]))

    def margins(choices: Array) -> Array:
        """Margins of all moments, shape (times, choices)."""
        by_x, by_y = moved(choices)
        return cycle.support.margins(*(by_x + by_y - middle))

    # Unknowns v: the four numbers and m, all in mm, so that steps and tolerances of the method fit.
    def room(v: Array) -> Array:
        slack: Array = 1e3 * margins(1e-3 * v[None, :4])[:, 0] - v[4]
        return slack

    def slopes(v: Array) -> Array:
        step = 1e-3
        moved_margins = 1e3 * margins(1e-3 * (v[:4] + step * np.vstack((np.eye(4), -np.eye(4)))))
        by_choice = (moved_margins[:, :4] - moved_margins[:, 4:]) / (2.0 * step)
        return np.column_stack((by_choice, np.full(len(by_choice), -1.0)))

    def cost(v: Array) -> float:
        return -float(v[4] + MEAN_WEIGHT * (room(v) + v[4]).mean())

    def steepest(v: Array) -> Array:
        return -np.append(MEAN_WEIGHT * slopes(v)[:, :4].mean(axis=0), 1.0)

    begin = np.append(1e3 * start, 1e3 * float(margins(start[None]).min()))
    with warnings.catch_warnings():
        # Its steps leave the bounds by a rounding error.
        warnings.filterwarnings("ignore", "Values in x were outside bounds")
        optimum = minimize(
            cost,
            begin,
            jac=steepest,
            method="SLSQP",
            bounds=[(1e3 * low, 1e3 * high) for low, high in limits] + [(None, None)],
            constraints={"type": "ineq", "fun": room, "jac": slopes},
            options={"maxiter": 100, "ftol": 1e-6},
        )
    better = np.clip(1e-3 * optimum.x[:4], *np.array(limits).T)
    reached = np.append(1e3 * better, 1e3 * float(margins(better[None]).min()))
    return Choice(*better.tolist()) if cost(reached) < cost(begin) else choice


GRID: Final = 40
"""Points along each of x_sd and x_ed."""
LATERAL_GRID: Final = 24
"""Points along each of y_d and y_m."""
MAX_TURNS: Final = 6
"""Maximum number of refinements of all four, each with new tables."""
Progress = Callable[[str], None]


class MarginGrid(NamedTuple):
    """Margins over a grid of two numbers."""

    first: Array
    """x_sd, or y_d, m."""
    second: Array
    """x_ed, or y_m, m."""
    margin: Array
    """Minimum over the cycle, shape (first, second), m."""
    score: Array
    """The same plus a little of the mean (`MEAN_WEIGHT`), m."""

    def best(self) -> tuple[int, int]:
        """Indices of the maximum score."""
        i, j = np.unravel_index(int(np.argmax(self.score)), self.score.shape)
        return int(i), int(j)


class CyclePlan(NamedTuple):
    """Result of a search."""

    choice: Choice
    margin: float
    """Margin of the choice, m."""


def search(cycle: Cycle, grid: int = GRID, progress: Progress = lambda _: None) -> CyclePlan:
    """The choice with the largest margin; a number that the parameters name keeps its value.

    Args:
        cycle: body and parameters.
        grid: points along each dimension.
        progress: called with the part of the search that begins.

    Raises:
        ConfigurationError: poses out of the legs' reach.
    """
    p = cycle.p
    half = 0.5 * p.D_s
    x = [half if value is None else value for value in (p.x_sd, p.x_ed)]
    y = [0.25 * p.l_FA * k if value is None else value for k, value in ((0.3, p.y_d), (1.2, p.y_m))]
    choice = Choice(0.8 * x[0] if p.x_sd is None else x[0], 0.8 * x[1] if p.x_ed is None else x[1], y[0], y[1])
    if None not in (p.x_sd, p.x_ed, p.y_d, p.y_m):
        return CyclePlan(choice, cycle.margin(choice))
    for again in ("", ", again"):
        if None in (p.y_d, p.y_m):
            progress(f"y_d, y_m{again}")
            choice, _ = across(cycle, choice)
        if None in (p.x_sd, p.x_ed):
            progress(f"x_sd, x_ed{again}")
            choice, _ = along(cycle, choice, grid)
    for turn in range(1, MAX_TURNS + 1):
        progress(f"all four, turn {turn}")
        before, choice = choice, refined(cycle, choice, grid)
        if choice == before:
            break
    choice = walkable(cycle, choice)
    return CyclePlan(choice, cycle.margin(choice))


def walkable(cycle: Cycle, choice: Choice) -> Choice:
    """The first choice that the joints' ranges allow from a choice to the middle of bound (11).

    The margin knows no joint; of a V4 and later the optimum asks half a degree too much of an ankle. Where the
    ranges allow none of them, the choice itself.
    """
    p = cycle.p
    middle = choice._replace(
        x_sd=0.25 * p.D_s if p.x_sd is None else p.x_sd, x_ed=0.25 * p.D_s if p.x_ed is None else p.x_ed
    )
    for part in np.linspace(0.0, 1.0, 21):
        tried = Choice(*(np.array(choice) + part * np.subtract(middle, choice)).tolist())
        try:
            check_walkable(cycle.body, HuangGait(msgspec.structs.replace(p, **tried._asdict()), cycle.body))
        except ConfigurationError:
            continue
        return tried
    return choice


def along(cycle: Cycle, choice: Choice, grid: int = GRID) -> tuple[Choice, MarginGrid]:
    """The best x_sd and x_ed of a grid within bound (11).

    Args:
        cycle: body and parameters.
        choice: y_d and y_m are taken from it.
        grid: points along each dimension.
    """
    (first, second), _ = grids(cycle.p, grid)
    best, surface = _best_of(cycle, choice, "x", sample_x(cycle.p, cycle.times), (first, second))
    return choice._replace(x_sd=best[0], x_ed=best[1]), surface


def across(cycle: Cycle, choice: Choice) -> tuple[Choice, MarginGrid]:
    """The best y_d and y_m of a grid from the path's middle to the ankles' line.

    Args:
        cycle: body and parameters.
        choice: x_sd and x_ed are taken from it.
    """
    _, (first, second) = grids(cycle.p, LATERAL_GRID)
    best, surface = _best_of(cycle, choice, "y", sample_y(cycle.p, cycle.times), (first, second))
    return choice._replace(y_d=best[0], y_m=best[1]), surface


def _best_of(
    cycle: Cycle, choice: Choice, axis: str, motions: Linear, axes: tuple[Array, Array]
) -> tuple[tuple[float, float], MarginGrid]:
    a, b = (grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
    u: Sampled = motions.at(a, b)
    margins = cycle.support.margins(*tabulated(cycle, choice, axis, motions, axes).zmp(u))
    minimum, shape = margins.min(axis=0), (len(axes[0]), len(axes[1]))
    score = minimum + MEAN_WEIGHT * margins.mean(axis=0)
    surface = MarginGrid(axes[0], axes[1], minimum.reshape(shape), score.reshape(shape))
    i, j = surface.best()
    return (float(axes[0][i]), float(axes[1][j])), surface
