"""(13), (14) for many motions of the hip at once.

At any moment of a cycle everything but one coordinate u of the hip is given (x in the search for x_sd and
x_ed, y in that for y_d and y_m), and so is the pose of every body as a function of u. Along a motion u(t) the
numerators and the denominator are polynomials in u', u'^2 and u'' whose factors depend on time and u alone.
These factors are smooth in u: a few nodes hold them to a micrometre of the zero moment point, where the inverse
kinematics of each candidate would cost hundreds of times as much.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.polynomial import chebyshev

from bridge.types import Array
from nao_hil.design.huang.motions import Sampled
from walker.gaits.huang.multibody import STEP, Bodies

NODES: Final = 7
MIN_HALF_SPAN: Final = 2e-3
"""Minimum of half the range over which the factors are tabulated, m."""
BLOCK_SIZE: Final = 16384
"""Points of time and motion that are evaluated at once: they fit into the processor's cache."""
FramesAt = Callable[[float, float], Array]
"""Time, s, and u, m, to the frames of all bodies."""


class ZmpTable:
    """Tabulated factors of (13), (14) over the times of a cycle.

    Args:
        bodies: of the robot.
        frames_at: the pose as a function of time and u.
        times: s.
        lower: minimum of u at each time, m.
        upper: maximum of u at each time, m.

    Raises:
        UnreachableError: a pose in the range is out of the legs' reach.
    """

    def __init__(self, bodies: Bodies, frames_at: FramesAt, times: Array, lower: Array, upper: Array) -> None:
        self._middle = 0.5 * (lower + upper)
        self._half = np.maximum(0.5 * (upper - lower), MIN_HALF_SPAN)
        nodes = chebyshev.chebpts1(NODES)
        places = self._middle[:, None] + self._half[:, None] * nodes
        frames = np.array(
            [
                [[frames_at(t + shift, u) for u in row] for t, row in zip(times, places, strict=True)]
                for shift in (-STEP, 0.0, STEP)
            ]
        )
        before, now, after = frames
        by_u, by_uu = self._differentiate(nodes)
        in_t = (after - before) / (2.0 * STEP)
        in_u = np.einsum("tnm,tm...->tn...", by_u, now)
        second = [
            (after - 2.0 * now + before) / STEP**2,
            2.0 * np.einsum("tnm,tm...->tn...", by_u, in_t),
            np.einsum("tnm,tm...->tn...", by_uu, now),
            in_u,
        ]
        factors = bodies.moments(now, second, [in_t, in_u])
        # As polynomials in the place within the range, (power, x y weight, 1 u' u'^2 u'', time).
        inverse = np.linalg.inv(np.vander(nodes, increasing=True))
        self._polynomials = np.einsum("pn,kjtn->pkjt", inverse, factors)

    def _differentiate(self, nodes: Array) -> tuple[Array, Array]:
        """First and second derivative along u at the nodes, each (times, nodes, nodes)."""
        vander = np.vander(nodes, increasing=True)
        powers = np.arange(NODES)
        slope, bend = np.zeros_like(vander), np.zeros_like(vander)
        slope[:, 1:] = vander[:, :-1] * powers[1:]
        bend[:, 2:] = vander[:, :-2] * powers[2:] * powers[1:-1]
        inverse = np.linalg.inv(vander)
        scale = self._half[:, None, None]
        return (slope @ inverse) / scale, (bend @ inverse) / scale**2

    def zmp(self, u: Sampled) -> tuple[Array, Array]:
        """Zero moment points, x and y, m, of the shape of u.

        Args:
            u: shape (times, motions), m and s.
        """
        # x = sum(x factors) / sum(weight factors), each a polynomial in the place within the range, by blocks.
        x, y = np.empty_like(u.position), np.empty_like(u.position)
        times, motions = u.position.shape
        rows = max(1, BLOCK_SIZE // motions)
        for begin in range(0, times, rows):
            part = slice(begin, begin + rows)
            s = (u.position[part] - self._middle[part, None]) / self._half[part, None]
            rate, acceleration = u.velocity[part], u.acceleration[part]
            terms = (rate, rate * rate, acceleration)
            sums = []
            for k in range(3):
                factors = self._polynomials[:, k, :, part, None]
                total = _horner(factors[:, 0], s)
                for j, term in enumerate(terms, start=1):
                    total += term * _horner(factors[:, j], s)
                sums.append(total)
            x[part], y[part] = sums[0] / sums[2], sums[1] / sums[2]
        return x, y


def _horner(coefficients: Array, s: Array) -> Array:
    value = np.broadcast_to(coefficients[-1], s.shape).copy()
    for c in coefficients[-2::-1]:
        value *= s
        value += c
    return value
