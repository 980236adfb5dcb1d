"""Footholds on known ground: steps of even length, except where a sole would rest across an edge."""

from __future__ import annotations

from typing import Final

import numpy as np

from bridge.types import Array
from walker.gaits.huang.foot import FootShape, Placement
from walker.gaits.huang.parameters import HuangParameters, refuse

_GRID_SPACING: Final = 0.005
"""m; of the places that are tried."""
_EDGE_CLEARANCE: Final = 0.015
"""Kept free between a sole and an edge, m: the way in which a toe rises by the step's height."""
_EDGE_RANGE: Final = 0.2
"""m; further behind an edge nothing of a foot is left."""
_HORIZON: Final = 6
"""Steps looked ahead: a long step over an edge takes a short one before it."""


class Footholds:
    """Chooses places for the feet.

    Args:
        p: of the gait, its ground included.
        shape: of the foot.
        half_width: of a sole, m.
    """

    def __init__(self, p: HuangParameters, shape: FootShape, half_width: float) -> None:
        self._p, self._shape, self._half_width = p, shape, half_width

    def check_width(self) -> None:
        """The ground is alike under both feet, over the whole width of their soles.

        Raises:
            ConfigurationError: names the edge of which a foot would tread on one part only.
        """
        ground, half = self._p.ground, 0.5 * self._p.l_FA
        across = (*self._sides(half), *self._sides(-half))
        for edge in ground.edges():
            for x in (edge - 1e-6, edge + 1e-6):
                if len({ground.height(x, [y]) for y in across}) > 1:
                    refuse(
                        f"the ground at x = {edge:.3f} m differs across the walk; an edge must reach from y = "
                        f"{min(across):.3f} to {max(across):.3f} m, or stay out of it"
                    )

    def place(self, x: float, y: float) -> Placement:
        """Height and slope of the ground under a foot at a place.

        Args:
            x: along the walk, m.
            y: of the ankle, m.
        """
        ground = self._p.ground
        return Placement(x, ground.at(x, self._sides(y)), ground.slope)

    def next(self, stance: float, y: float) -> Placement:
        """Pose2D of the swing foot ahead of a stance foot.

        Args:
            stance: x of the stance foot, m.
            y: of the swing foot; the other foot is as far to the other side, m.

        Raises:
            ConfigurationError: no step up to D_max gets over an edge.
        """
        p = self._p
        low, high = stance - _EDGE_RANGE, stance + _HORIZON * p.D_max + _EDGE_RANGE
        if not any(low < edge < high for edge in p.ground.edges()):
            return self.place(stance + p.D_s, y)
        return self.place(stance + self._way(stance, y), y)

    def _way(self, stance: float, y: float) -> float:
        """The first of the next steps that together depart least, in squares, from D_s."""
        p = self._p
        shorter, longer = int(p.D_s / _GRID_SPACING - 1e-9), int((p.D_max - p.D_s) / _GRID_SPACING + 1e-9)
        shifts = np.arange(-shorter, longer + 1)
        costs = shifts.astype(np.float64) ** 2
        sides = {1: self._forbidden(y), 0: self._forbidden(-y)}
        options: Array = np.zeros((1, len(shifts)))
        ahead: Array = np.zeros(_HORIZON * len(shifts))
        for n in range(_HORIZON, 0, -1):
            # All places after n steps, as multiples of the raster off even steps.
            raster = np.arange(-n * shorter, n * longer + 1)
            value = ahead[: len(raster)].copy()
            places = stance + n * p.D_s + _GRID_SPACING * raster
            for begin, end in sides[n % 2]:
                value[(places > begin) & (places < end)] = np.inf
            before = len(raster) - len(shifts) + 1
            options = np.array([value[i : i + len(shifts)] + costs for i in range(before)])
            ahead = options.min(axis=1)
        if not np.isfinite(ahead[0]):
            edges = ", ".join(f"{edge:.3f}" for edge in p.ground.edges())
            refuse(
                f"no steps of up to D_max = {p.D_max} m lead from x = {stance:.3f} m over the ground's edges "
                f"at x = {edges} m with {1e3 * p.overhang:.0f} mm of a sole over an edge; make D_max or "
                "overhang larger"
            )
        return float(p.D_s + _GRID_SPACING * shifts[int(np.argmin(options[0]))])

    def _forbidden(self, y: float) -> list[tuple[float, float]]:
        """Intervals of x in which no ankle may be: the sole would overhang an edge too far."""
        ground, shape, over = self._p.ground, self._shape, self._p.overhang
        forbidden = []
        for edge in ground.edges():
            before, after = (ground.height(edge + shift, self._sides(y)) for shift in (-1e-6, 1e-6))
            if after > before:
                forbidden.append((edge - shape.l_af - _EDGE_CLEARANCE, edge + shape.l_ab - over))
            elif after < before:
                forbidden.append((edge - shape.l_af + over, edge + shape.l_ab + _EDGE_CLEARANCE))
        return forbidden

    def _sides(self, y: float) -> tuple[float, float, float]:
        return y - self._half_width, y, y + self._half_width
