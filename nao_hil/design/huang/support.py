"""Support polygons over a cycle whose soles roll over heel and toe.

A rigid tilted sole touches along an edge, which has no area. Soles and drives are compliant: all of a sole that
is less than `sole_give` above the ground counts as contact, so the polygon shrinks as a foot turns.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull

from bridge.body import Body
from bridge.body.sole import sole_hull
from bridge.types import Array
from nao_hil.design.huang.table import BLOCK
from walker.gaits.huang.foot import FootPath, FootShape
from walker.gaits.huang.parameters import HuangParameters


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
        found = np.empty_like(x)
        rows = max(1, BLOCK // x.shape[1])
        for begin in range(0, len(x), rows):
            part = slice(begin, begin + rows)
            furthest = np.full_like(x[part], -np.inf)
            for n_x, n_y, d in self._planes[:, :, part, None]:
                np.maximum(furthest, n_x * x[part] + n_y * y[part] + d, out=furthest)
            found[part] = -furthest
        return found
