"""The hip's motion piece by piece: from rest, through cycles of any length of step, to rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

from walker.functions import MotionState, quintic
from walker.planning.huang.foot import Placement
from walker.planning.huang.hip import Choice, ends_of_cycle, hip_y, hip_z
from walker.planning.huang.parameters import HuangParameters
from walker.planning.huang.rest import sway
from walker.planning.huang.spline import Cubic, joined


@dataclass(frozen=True)
class Piece:
    """The hip over a start, a cycle or a stop; time counts from its beginning."""

    duration: float
    """s"""
    x: Cubic
    y: Cubic
    z: tuple[tuple[float, Cubic], ...]
    """Heights over the ground, m, each with the time from which it holds, s."""
    ground: tuple[float, float]
    """Height of the patch that the hip comes from and of the one that it goes to, m."""
    rise: float
    """Time in which it changes over, s."""
    slope: float
    """Of the floor, rad."""

    def hip(self, t: float) -> tuple[float, float, float]:
        """Middle between the hip joints, walk frame, m; also a little before and after the piece."""
        x, y = self.x.at(t).position, self.y.at(t).position
        height = next(spline for begin, spline in reversed(self.z) if begin <= t)
        ground = quintic(*self.ground, self.rise, t).position - math.tan(self.slope) * x
        return x, y, height.at(t).position + ground

    @property
    def level(self) -> float:
        """Height of the patch at its end, m."""
        return self.ground[1]


class Pieces:
    """Makes the pieces of a configuration.

    Args:
        p: of the gait.
        choice: of the search.
        rest: x of the hip at rest, from the ankles, m.
        height: of the centre of mass, m.
    """

    def __init__(self, p: HuangParameters, choice: Choice, rest: float, height: float) -> None:
        self._p, self._choice, self._rest = p, choice, rest
        self._end_x, end_y = ends_of_cycle(p, choice)
        self._y, self._z = hip_y(p, choice.y_d, choice.y_m), hip_z(p)
        self._start, self._stop = sway(p, end_y, height)
        self._half = 0.5 * (p.T_c + p.T_d)

    def stand(self, x: float, level: float) -> Piece:
        """At rest with the ankles at x."""
        return self._still(x, _rest(0.0), (level, level))

    def start(self, x: float, level: float, side: float) -> Piece:
        """From rest with the ankles at x to a first cycle on the left (1) or right (-1) foot."""
        return self._still(x, _mirrored(self._start, side), (level, level))

    def stop(self, x: float, levels: tuple[float, float], side: float) -> Piece:
        """To rest with the ankles at x, in place of a cycle on the left (1) or right (-1) foot."""
        return self._still(x, _mirrored(self._stop, side), levels)

    def cycle(
        self, feet: tuple[Placement, Placement, Placement], levels: tuple[float, float], side: float
    ) -> Piece:
        """A cycle.

        Steps of another length than D_s scale the ends of the hip's motion (8) and their derivatives; they meet
        where the steps do.

        Args:
            feet: where the swing foot comes from, the stance foot, where the swing foot lands.
            levels: height of the ground below the last stance foot and below this one, m.
            side: 1 on the left foot, -1 on the right one.
        """
        p, (rear, stance, landing) = self._p, feet
        before, after = (stance.x - rear.x) / p.D_s, (landing.x - stance.x) / p.D_s
        middle = stance.x + self._rest + before * (p.x_0 - self._choice.x_sd - self._rest)
        return Piece(
            p.T_c,
            joined((0.0, p.T_d, p.T_c), self._between(rear.x, before), middle, self._between(stance.x, after)),
            _mirrored(self._y, side),
            self._heights(from_rest=before == 0.0, to_rest=after == 0.0),
            levels,
            self._half,
            p.ground.slope,
        )

    def _between(self, rear: float, ratio: float) -> MotionState:
        """X where the double support of a step of `ratio` times D_s begins."""
        x, velocity, acceleration = self._end_x
        return MotionState(rear + self._rest + ratio * (x - self._rest), ratio * velocity, ratio * acceleration)

    def _heights(self, *, from_rest: bool, to_rest: bool) -> tuple[tuple[float, Cubic], ...]:
        """Z by (7) in three parts, its ends replaced where the walk begins or ends."""
        p, half = self._p, self._half
        top, low, mean = self._z.at(half), MotionState(p.H_min, 0.0, 0.0), 0.5 * (p.H_min + p.H_max)
        before = Cubic(self._z.breaks - p.T_c, self._z.coefficients)
        parts = [(-math.inf, before), (0.5 * p.T_d, self._z)]
        if from_rest:
            parts = [(-math.inf, joined((0.0, 0.5 * half, half), low, mean, top)), (half, self._z)]
        if to_rest:
            parts = [part for part in parts if part[0] < half]
            parts.append((half, joined((half, 0.5 * (half + p.T_c), p.T_c), top, mean, low)))
        return tuple(parts)

    def _still(self, x: float, y: Cubic, levels: tuple[float, float]) -> Piece:
        p = self._p
        z = ((-math.inf, _rest(p.H_min)),)
        return Piece(p.T_start, _rest(x + self._rest), y, z, levels, p.T_start, p.ground.slope)


def _rest(position: float) -> Cubic:
    return Cubic((0.0, 1.0), [[0.0], [0.0], [0.0], [position]])


def _mirrored(spline: Cubic, side: float) -> Cubic:
    return Cubic(spline.breaks, side * spline.coefficients)
