"""The search for the motion of the hip with the largest stability margin ((11), (12)).

The source tries all x_sd, x_ed in (0, 0.5 D_s). So it is here, all pairs over the whole cycle at once, and
the same for y_d, y_m, which the source does not have. The two searches take turns, because the polygon of a
double support couples x and y: each pair alone gets stuck where the least margin has a ridge across them. From
there all four are refined together: the largest m that no moment's margin is less than, by sequential quadratic
programming.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from scipy.optimize import minimize

from bridge.datasheet import Body
from walker.errors import UnreachableError
from walker.gait.huang.foot import FootPath, FootShape, Placement
from walker.gait.huang.hip import Choice, Linear, Sampled, hip_x, hip_y, hip_z, sample_x, sample_y
from walker.gait.huang.multibody import Ankle, Bodies
from walker.gait.huang.parameters import HuangParameters, check_bounds, refuse
from walker.gait.huang.spline import even
from walker.gait.huang.support import CycleSupport
from walker.gait.huang.table import ZmpTable
from walker.gravity import GRAVITY
from walker.kinematics.transforms import Array

SAMPLE: Final = 0.01
"""s; between the moments of a cycle at which the margin is taken."""
LATERAL_GRID: Final = 24
TURNS: Final = 6
"""Most refinements of all four, each with new tables."""
MEAN_SHARE: Final = 0.02
"""Weight of the mean margin over the cycle beside the least one. The least margin has flat tops, of which this
picks a point; of the least margin it costs less than 0.05 mm."""
Progress = Callable[[str], None]


class Surface(NamedTuple):
    """Margins over a grid of two numbers."""

    first: Array
    """x_sd, or y_d, m."""
    second: Array
    """x_ed, or y_m, m."""
    margin: Array
    """Least over the cycle, shape (first, second), m."""
    score: Array
    """The same and a little of the mean (`MEAN_SHARE`), m."""

    def best(self) -> tuple[int, int]:
        """Place of the largest score."""
        i, j = np.unravel_index(int(np.argmax(self.score)), self.score.shape)
        return int(i), int(j)


class CyclePlan(NamedTuple):
    """What a search found."""

    choice: Choice
    margin: float
    """Of the choice, m."""
    surface: Surface
    """Over x_sd and x_ed at the chosen y_d, y_m."""
    lateral: Surface
    """Over y_d and y_m."""


class Cycle:
    """The periodic cycle of a body, the left foot in front: everything but the choice.

    Args:
        p: parameters.
        body: data sheet.
        arms: joint angles of arms and head that are not zero, rad.
        dt: s, between samples.

    Raises:
        ConfigurationError: parameters out of their bounds.
    """

    def __init__(self, p: HuangParameters, body: Body, arms: dict[str, float], dt: float = SAMPLE) -> None:
        check_bounds(p)
        self.p, self.bodies = p, Bodies(body, arms)
        self.times: Array = np.arange(0.0, p.T_c - 1e-9, dt).astype(np.float64)
        shape = FootShape.of(body)
        self.rear = FootPath(p, shape, Placement(0.0), Placement(2.0 * p.D_s))
        self.front = FootPath(p, shape, Placement(-p.D_s), Placement(p.D_s))
        self.support = CycleSupport(p, body, self.rear, self.front, self.times)
        self._z = hip_z(p)
        self._feet: dict[float, tuple[Ankle, Ankle]] = {}

    def frames(self, t: float, x: float, y: float) -> Array:
        """Frames of all bodies with the hips' middle at x, y, shape (bodies, 4, 4), m.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        return self.bodies.frames((x, y, self.height(t)), *self.feet(t))

    def height(self, t: float) -> float:
        """Of the hip joints, m."""
        return self._z.at(t if t >= 0.5 * self.p.T_d else t + self.p.T_c).position

    def feet(self, t: float) -> tuple[Ankle, Ankle]:
        """Left (front) and right (rear) foot."""
        if t not in self._feet:
            half = 0.5 * self.p.l_FA
            ankles = []
            for path, time, y in ((self.front, t + self.p.T_c, half), (self.rear, t, -half)):
                x, z, pitch = path.motion(time)
                ankles.append(Ankle(x.position, y, z.position, pitch.position))
            self._feet[t] = (ankles[0], ankles[1])
        return self._feet[t]

    def x_at(self, choice: Choice, t: float) -> float:
        """Of the hips' middle, m."""
        return hip_x(self.p, choice.x_sd, choice.x_ed).at(t).position + self.p.D_s / self.p.T_c * t

    def zmp(self, choice: Choice) -> tuple[Array, Array]:
        """Zero moment point over the cycle by poses alone, no table: x and y, shape (times,), m."""
        along, across = hip_x(self.p, choice.x_sd, choice.x_ed), hip_y(self.p, choice.y_d, choice.y_m)
        mean, step = self.p.D_s / self.p.T_c, 1e-3
        points = []
        for t in self.times.tolist():
            before, now, after = (
                self.frames(s, along.at(s).position + mean * s, across.at(s).position)
                for s in (t - step, t, t + step)
            )
            points.append(self.bodies.zmp(before, now, after, step))
        x, y = np.array(points).T
        return x, y

    def pendulum_zmp(self, choice: Choice) -> tuple[Array, Array]:
        """The same of a point mass that moves with the hip, at the height of the centre of mass: (3.4)."""
        p = self.p
        x = sample_x(p, self.times).at(np.array([choice.x_sd]), np.array([choice.x_ed]))
        y = sample_y(p, self.times).at(np.array([choice.y_d]), np.array([choice.y_m]))
        middle = 0.5 * (p.T_c + p.T_d)
        com = self.bodies.centre_of_mass(self.frames(middle, self.x_at(choice, middle), choice.y_m))
        ahead = com[0] - self.x_at(choice, middle)
        return (
            (x.position + ahead - x.acceleration * com[2] / GRAVITY)[:, 0],
            (y.position - y.acceleration * com[2] / GRAVITY)[:, 0],
        )

    def table(self, choice: Choice, axis: str, motions: Linear, corners: tuple[Array, Array]) -> ZmpTable:
        """Factors of (13), (14) along one axis, the other one as chosen."""
        u = motions.at(*corners).position
        try:
            if axis == "x":
                across = hip_y(self.p, choice.y_d, choice.y_m)
                return ZmpTable(
                    self.bodies,
                    lambda t, u: self.frames(t, u, across.at(t).position),
                    self.times,
                    u.min(axis=1),
                    u.max(axis=1),
                )
            return ZmpTable(
                self.bodies,
                lambda t, u: self.frames(t, self.x_at(choice, t), u),
                self.times,
                u.min(axis=1),
                u.max(axis=1),
            )
        except UnreachableError as error:
            refuse(f"{error}; lower H_max, or shorten D_s")
            raise AssertionError from None

    def margin(self, choice: Choice) -> float:
        """Stability margin d_zmp of a choice, by poses alone, m."""
        x, y = self.zmp(choice)
        return float(self.support.margins(x[:, None], y[:, None]).min())


def search(cycle: Cycle, progress: Progress = lambda _: None) -> CyclePlan:
    """The choice with the largest margin; what the parameters name stays as it is.

    Raises:
        ConfigurationError: poses out of the legs' reach.
    """
    p = cycle.p
    half = 0.5 * p.D_s
    x = [half if value is None else value for value in (p.x_sd, p.x_ed)]
    y = [0.25 * p.l_FA * k if value is None else value for k, value in ((0.3, p.y_d), (1.2, p.y_m))]
    choice = Choice(0.8 * x[0] if p.x_sd is None else x[0], 0.8 * x[1] if p.x_ed is None else x[1], y[0], y[1])
    for again in ("", ", again"):
        progress(f"y_d, y_m{again}")
        choice, _ = across(cycle, choice)
        progress(f"x_sd, x_ed{again}")
        choice, _ = along(cycle, choice)
    for turn in range(1, TURNS + 1):
        progress(f"all four, turn {turn}")
        before, choice = choice, _together(cycle, choice)
        if choice == before:
            break
    progress("margins around it")
    return CyclePlan(choice, cycle.margin(choice), along(cycle, choice)[1], across(cycle, choice)[1])


def admissible(p: HuangParameters, choice: Choice) -> bool:
    """Whether the search could have found it."""
    (x_sd, x_ed), (y_d, y_m) = _bounds(p, p.grid)
    return all(grid[0] <= value <= grid[-1] for grid, value in zip((x_sd, x_ed, y_d, y_m), choice, strict=True))


def along(cycle: Cycle, choice: Choice, n: int | None = None) -> tuple[Choice, Surface]:
    """The best x_sd and x_ed of a grid within bound (11), y_d and y_m as they are.

    Args:
        cycle: everything else.
        choice: y_d and y_m are taken from it.
        n: points along each dimension; None: those of the parameters.
    """
    (first, second), _ = _bounds(cycle.p, n or cycle.p.grid)
    best, surface = _best_of(cycle, choice, "x", sample_x(cycle.p, cycle.times), (first, second))
    return choice._replace(x_sd=best[0], x_ed=best[1]), surface


def across(cycle: Cycle, choice: Choice) -> tuple[Choice, Surface]:
    """The best y_d and y_m of a grid from the path's middle to the ankles' line, x_sd and x_ed as they are."""
    _, (first, second) = _bounds(cycle.p, LATERAL_GRID)
    best, surface = _best_of(cycle, choice, "y", sample_y(cycle.p, cycle.times), (first, second))
    return choice._replace(y_d=best[0], y_m=best[1]), surface


def _bounds(p: HuangParameters, n: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Grids of x_sd, x_ed and of y_d, y_m; a named one is one point. Bound (11) itself is not admissible."""
    along = np.arange(1, n + 1) / (n + 1) * 0.5 * p.D_s
    half = 0.5 * p.l_FA
    grids = (along, along, even(-0.2, 0.6, n) * half, even(0.2, 1.0, n) * half)
    named = (p.x_sd, p.x_ed, p.y_d, p.y_m)
    x_sd, x_ed, y_d, y_m = (
        grid if value is None else np.array([value]) for grid, value in zip(grids, named, strict=True)
    )
    return (x_sd, x_ed), (y_d, y_m)


def _table(cycle: Cycle, choice: Choice, axis: str, motions: Linear, axes: tuple[Array, Array]) -> ZmpTable:
    corners = np.array([(i, j) for i in axes[0][[0, -1]] for j in axes[1][[0, -1]]]).T
    return cycle.table(choice, axis, motions, (corners[0], corners[1]))


def _best_of(
    cycle: Cycle, choice: Choice, axis: str, motions: Linear, axes: tuple[Array, Array]
) -> tuple[tuple[float, float], Surface]:
    a, b = (grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
    u: Sampled = motions.at(a, b)
    margins = cycle.support.margins(*_table(cycle, choice, axis, motions, axes).zmp(u))
    least, shape = margins.min(axis=0), (len(axes[0]), len(axes[1]))
    score = least + MEAN_SHARE * margins.mean(axis=0)
    surface = Surface(axes[0], axes[1], least.reshape(shape), score.reshape(shape))
    i, j = surface.best()
    return (float(axes[0][i]), float(axes[1][j])), surface


def _together(cycle: Cycle, choice: Choice) -> Choice:
    """A choice of all four with no less margin; x of the ZMP is tabulated at the choice's y and y at its x."""
    p = cycle.p
    pairs = _bounds(p, p.grid)
    motions = sample_x(p, cycle.times), sample_y(p, cycle.times)
    tables = (
        _table(cycle, choice, "x", motions[0], pairs[0]),
        _table(cycle, choice, "y", motions[1], pairs[1]),
    )
    limits = [(float(grid[0]), float(grid[-1])) for pair in pairs for grid in pair]

    def margins(choices: Array) -> Array:
        """Of all moments, shape (times, choices), from choices of shape (choices, 4)."""
        x, _ = tables[0].zmp(motions[0].at(choices[:, 0], choices[:, 1]))
        _, y = tables[1].zmp(motions[1].at(choices[:, 2], choices[:, 3]))
        return cycle.support.margins(x, y)

    # In mm, so that steps and tolerances of the method fit.
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
        return -float(v[4] + MEAN_SHARE * (room(v) + v[4]).mean())

    def steepest(v: Array) -> Array:
        return -np.append(MEAN_SHARE * slopes(v)[:, :4].mean(axis=0), 1.0)

    start = np.array(choice)
    least = float(margins(start[None]).min())
    begin = np.append(1e3 * start, 1e3 * least)
    with warnings.catch_warnings():
        # its steps leave the bounds by a rounding error, and it says so
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
