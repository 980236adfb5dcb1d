"""The search for the motion of the hip with the largest stability margin ((11), (12)).

The source tries all x_sd, x_ed in (0, 0.5 D_s). So it is here, all pairs over the whole cycle at once, and
the same for y_d, y_m, which the source does not have. The best pair of the grid is then refined by the method
of Nelder and Mead. The two searches take turns, because the polygon of a double support couples x and y.
"""

from __future__ import annotations

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
Progress = Callable[[str], None]


class Surface(NamedTuple):
    """Margins over a grid of two numbers."""

    first: Array
    """x_sd, or y_d, m."""
    second: Array
    """x_ed, or y_m, m."""
    margin: Array
    """Shape (first, second), m."""

    def best(self) -> tuple[int, int]:
        """Place of the largest margin."""
        i, j = np.unravel_index(int(np.argmax(self.margin)), self.margin.shape)
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
    progress("y_d, y_m: coarse")
    choice, lateral = across(cycle, choice, refine=False)
    for last in (False, True):
        progress("x_sd, x_ed" + (": refined" if last else ""))
        choice, surface = along(cycle, choice)
        progress("y_d, y_m" + (": refined" if last else ""))
        choice, lateral = across(cycle, choice)
    return CyclePlan(choice, cycle.margin(choice), surface, lateral)


def along(cycle: Cycle, choice: Choice, n: int | None = None, refine: bool = True) -> tuple[Choice, Surface]:
    """Search over x_sd and x_ed within bound (11)."""
    p = cycle.p
    bound = 0.5 * p.D_s
    axis = np.arange(1, (n or p.grid) + 1) / ((n or p.grid) + 1) * bound
    inside = float(axis[0]), float(axis[-1])  # the bound itself is not admissible
    first = axis if p.x_sd is None else np.array([p.x_sd])
    second = axis if p.x_ed is None else np.array([p.x_ed])
    best, surface = _search(
        cycle, choice, "x", sample_x(p, cycle.times), (first, second), (inside, inside), refine
    )
    return choice._replace(x_sd=best[0], x_ed=best[1]), surface


def across(cycle: Cycle, choice: Choice, refine: bool = True) -> tuple[Choice, Surface]:
    """Search over y_d and y_m: from the path's middle to the ankles' line."""
    p = cycle.p
    bound = 0.5 * p.l_FA
    n = LATERAL_GRID
    first = even(-0.2, 0.6, n) * bound if p.y_d is None else np.array([p.y_d])
    second = even(0.2, 1.0, n) * bound if p.y_m is None else np.array([p.y_m])
    limits = ((-0.2 * bound, 0.6 * bound), (0.2 * bound, bound))
    best, surface = _search(cycle, choice, "y", sample_y(p, cycle.times), (first, second), limits, refine)
    return choice._replace(y_d=best[0], y_m=best[1]), surface


def _search(
    cycle: Cycle,
    choice: Choice,
    axis: str,
    motions: Linear,
    axes: tuple[Array, Array],
    limits: tuple[tuple[float, float], tuple[float, float]],
    refine: bool,
) -> tuple[tuple[float, float], Surface]:
    a, b = (grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
    ends = [(grid[0], grid[-1]) if len(grid) == 1 else limit for grid, limit in zip(axes, limits, strict=True)]
    corners = np.array([(i, j) for i in ends[0] for j in ends[1]]).T
    table = cycle.table(choice, axis, motions, (corners[0], corners[1]))

    def margins(a: Array, b: Array) -> Array:
        u: Sampled = motions.at(a, b)
        least: Array = cycle.support.margins(*table.zmp(u)).min(axis=0)
        return least

    surface = Surface(axes[0], axes[1], margins(a, b).reshape(len(axes[0]), len(axes[1])))
    i, j = surface.best()
    best = float(axes[0][i]), float(axes[1][j])
    free = [k for k in range(2) if len(axes[k]) > 1]
    if refine and free:
        best = _refined(margins, best, free, ends, axes)
    return best, surface


def _refined(
    margins: Callable[[Array, Array], Array],
    start: tuple[float, float],
    free: list[int],
    ends: list[tuple[float, float]],
    axes: tuple[Array, Array],
) -> tuple[float, float]:
    """Nelder and Mead from the best point of the grid, within the bounds."""

    def whole(part: Array) -> tuple[float, float]:
        found = list(start)
        for k, value in zip(free, part, strict=True):
            found[k] = float(value)
        return found[0], found[1]

    def cost(part: Array) -> float:
        a, b = whole(part)
        return -float(margins(np.array([a]), np.array([b]))[0])

    begin = np.array([start[k] for k in free])
    cells = [0.5 * (axes[k][1] - axes[k][0]) for k in free]
    simplex = np.vstack([begin, *(begin + np.eye(len(free))[i] * cell for i, cell in enumerate(cells))])
    found = minimize(
        cost,
        begin,
        method="Nelder-Mead",
        bounds=[ends[k] for k in free],
        options={"initial_simplex": simplex, "xatol": 1e-5, "fatol": 1e-6, "maxfev": 120},
    )
    return whole(found.x) if found.fun <= cost(begin) else start
