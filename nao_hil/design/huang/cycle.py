"""The periodic cycle of the gait huang: poses, zero moment point, support polygons, stability margin."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull

from bridge.body import Body
from bridge.body.inverse_kinematics import UnreachableError
from bridge.body.quantities import GRAVITY
from bridge.body.sole import sole_hull
from bridge.types import Array
from nao_hil.design.huang.motions import Linear, sample_x, sample_y
from nao_hil.design.huang.table import BLOCK_SIZE, ZmpTable
from walker.gaits.huang.foot import FootPath, FootShape, Placement
from walker.gaits.huang.hip import Choice, hip_x, hip_y, hip_z
from walker.gaits.huang.multibody import Ankle, Bodies
from walker.gaits.huang.parameters import HuangParameters, check_bounds, refuse


def contact(outline: Array, shape: FootShape, x: float, z: float, pitch: float, give: float) -> Array:
    """The part of a sole that bears load on z = 0, shape (n, 2), foot axes projected to the ground, m.

    Args:
        outline: convex, about the ankle, shape (n, 2), m.
        shape: of the foot.
        x: of the ankle, m.
        z: of the ankle, m.
        pitch: rad.
        give: m.
    """
    s, c = math.sin(pitch), math.cos(pitch)
    # Height of the sole at a point of the foot: z - c l_an - s x_f.
    above = z - c * shape.l_an - give
    kept = outline if abs(s) < 1e-12 else _clip(outline, above / s, 1.0 if s > 0.0 else -1.0)
    if len(kept) == 0 or (abs(s) < 1e-12 and above > 0.0):
        return np.empty((0, 2))
    return np.column_stack((x + c * kept[:, 0] - s * shape.l_an, kept[:, 1]))


def _clip(outline: Array, at: float, sign: float) -> Array:
    """The part of a convex polygon on one side of a line x = at."""
    kept = []
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        inside, beyond = sign * (a[0] - at) >= 0.0, sign * (b[0] - at) >= 0.0
        if inside:
            kept.append(a)
        if inside != beyond:
            kept.append(a + (at - a[0]) / (b[0] - a[0]) * (b - a))
    return np.array(kept).reshape(-1, 2)


class CycleSupport:
    """Support polygons over the periodic cycle, the left foot in front; flat ground.

    Args:
        p: of the gait.
        body: data sheet.
        rear: path of the right foot, from x = 0.
        front: path of the left foot, to x = D_s.
        times: from the beginning of double support, s.
    """

    def __init__(self, p: HuangParameters, body: Body, rear: FootPath, front: FootPath, times: Array) -> None:
        shape, half = FootShape.of(body), 0.5 * p.l_FA
        soles = {"L": sole_hull(body, "L"), "R": sole_hull(body, "R")}
        behind, ahead = rear.sample(times), front.sample(times + p.T_c)
        self.polygons: list[Array] = []
        """Corners, counter-clockwise, each (n, 2), m."""
        for i, t in enumerate(times):
            foot = contact(soles["L"], shape, ahead.x[i], ahead.z[i], ahead.pitch[i], p.sole_give)
            corners = [foot + np.array([0.0, half])]
            if t <= p.T_d:
                sole = contact(soles["R"], shape, behind.x[i], behind.z[i], behind.pitch[i], p.sole_give)
                corners.append(sole - np.array([0.0, half]))
            points = np.concatenate(corners)
            self.polygons.append(points[ConvexHull(points).vertices])
        planes = [ConvexHull(polygon).equations for polygon in self.polygons]
        count = max(len(p) for p in planes)
        # The same number for each moment, the last one repeated: (plane, n_x n_y d, time).
        self._planes = np.array([np.vstack((p, np.repeat(p[-1:], count - len(p), axis=0))) for p in planes])
        self._planes = self._planes.transpose(1, 2, 0)

    def margins(self, x: Array, y: Array) -> Array:
        """Distance of points from the polygons' borders, positive inside, of the points' shape, m.

        Args:
            x: m, shape (times, points).
            y: of the same shape.
        """
        margins = np.empty_like(x)
        rows = max(1, BLOCK_SIZE // x.shape[1])
        for begin in range(0, len(x), rows):
            part = slice(begin, begin + rows)
            furthest = np.full_like(x[part], -np.inf)
            for n_x, n_y, d in self._planes[:, :, part, None]:
                np.maximum(furthest, n_x * x[part] + n_y * y[part] + d, out=furthest)
            margins[part] = -furthest
        return margins


SAMPLE_TIME: Final = 0.01
"""Time between the moments of a cycle at which the margin is computed, s."""


class Cycle:
    """The periodic cycle of a body, the left foot in front, without the choice of the hip motion.

    Args:
        p: parameters.
        body: data sheet.
        arms: joint angles of arms and head that are not zero, rad.
        dt: s, between samples.

    Raises:
        ConfigurationError: parameters out of their bounds.
    """

    def __init__(self, p: HuangParameters, body: Body, arms: dict[str, float], dt: float = SAMPLE_TIME) -> None:
        check_bounds(p)
        self.p, self.body, self.bodies = p, body, Bodies(body, arms)
        self.times: Array = np.arange(0.0, p.T_c - 1e-9, dt).astype(np.float64)
        shape = FootShape.of(body)
        self.rear = FootPath(p, shape, Placement(0.0), Placement(2.0 * p.D_s))
        self.front = FootPath(p, shape, Placement(-p.D_s), Placement(p.D_s))
        self.support = CycleSupport(p, body, self.rear, self.front, self.times)
        self._z = hip_z(p)
        self._feet: dict[float, tuple[Ankle, Ankle]] = {}

    def frames(self, t: float, x: float, y: float) -> Array:
        """Frames of all bodies, shape (bodies, 4, 4), m.

        Args:
            t: from the beginning of double support, s.
            x: of the hips' middle, m.
            y: of the hips' middle, m.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        return self.bodies.frames((x, y, self.height(t)), *self.feet(t))

    def height(self, t: float) -> float:
        """Height of the hip joints at a time, s, m."""
        return self._z.at(t if t >= 0.5 * self.p.T_d else t + self.p.T_c).position

    def feet(self, t: float) -> tuple[Ankle, Ankle]:
        """Left (front) and right (rear) foot at a time, s."""
        if t not in self._feet:
            half = 0.5 * self.p.l_FA
            ankles = []
            for path, time, y in ((self.front, t + self.p.T_c, half), (self.rear, t, -half)):
                x, z, pitch = path.motion(time)
                ankles.append(Ankle(x.position, y, z.position, pitch.position))
            self._feet[t] = (ankles[0], ankles[1])
        return self._feet[t]

    def x_of(self, choice: Choice) -> Callable[[float], float]:
        """X of the hips' middle for a choice, m, as a function of time, s."""
        along, mean = hip_x(self.p, choice.x_sd, choice.x_ed), self.p.D_s / self.p.T_c
        return lambda t: along.at(t).position + mean * t

    def zmp(self, choice: Choice) -> tuple[Array, Array]:
        """Zero moment point over the cycle by poses alone, no table: x and y, shape (times,), m."""
        along, across, step = self.x_of(choice), hip_y(self.p, choice.y_d, choice.y_m), 1e-3
        points = []
        for t in self.times.tolist():
            before, now, after = (
                self.frames(s, along(s), across.at(s).position) for s in (t - step, t, t + step)
            )
            points.append(self.bodies.zmp(before, now, after, step))
        x, y = np.array(points).T
        return x, y

    def pendulum_zmp(self, choice: Choice) -> tuple[Array, Array]:
        """The same of a point mass (3.4) that moves with the hip at the height of the centre of mass."""
        p = self.p
        x = sample_x(p, self.times).at(np.array([choice.x_sd]), np.array([choice.x_ed]))
        y = sample_y(p, self.times).at(np.array([choice.y_d]), np.array([choice.y_m]))
        middle = 0.5 * (p.T_c + p.T_d)
        hip = self.x_of(choice)(middle)
        ahead, _, height = self.bodies.centre_of_mass(self.frames(middle, hip, choice.y_m)) - (hip, 0.0, 0.0)
        return (
            (x.position + ahead - x.acceleration * height / GRAVITY)[:, 0],
            (y.position - y.acceleration * height / GRAVITY)[:, 0],
        )

    def table(self, choice: Choice, axis: str, motions: Linear, corners: tuple[Array, Array]) -> ZmpTable:
        """Factors of (13), (14) along one axis, the other one as chosen.

        Args:
            choice: for the other axis.
            axis: `x` or `y`.
            motions: along the axis.
            corners: of the searched range: first and second numbers, m.

        Raises:
            ConfigurationError: a pose is out of the legs' reach.
        """
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
            along = self.x_of(choice)
            return ZmpTable(
                self.bodies,
                lambda t, u: self.frames(t, along(t), u),
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
