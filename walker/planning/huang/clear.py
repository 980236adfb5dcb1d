"""Swings that clear the edges of known ground."""

from __future__ import annotations

from typing import Final

from bridge.body import Body
from bridge.body.sole import sole_hull
from walker.planning.huang.foot import Apex, FootPath, FootShape, Placement
from walker.planning.huang.parameters import HuangParameters, refuse
from walker.planning.huang.spline import even

_SHIFTS: Final = (
    (0.0, 0.0),
    (-0.1, -0.1),
    (0.1, 0.1),
    (-0.1, -0.25),
    (0.1, 0.25),
    (-0.15, -0.35),
    (0.15, 0.35),
)
"""Of the apex in time and way, fractions of the swing: early and short up a step, late and far down one."""
_RAISES: Final = (0.0, 0.004, 0.008, 0.012)
"""m"""
_MOMENTS: Final = 60
_TOLERANCE: Final = 1e-9
"""m; rounding of a sole that rolls on the ground."""


class ClearPaths:
    """Makes the paths of the feet over known ground.

    Args:
        p: of the gait, its ground included.
        body: data sheet.
    """

    def __init__(self, p: HuangParameters, body: Body) -> None:
        self._p, self._shape = p, FootShape.of(body)
        sole = sole_hull(body, "L")
        self._along = sole[:, 0]
        self._half_width = max(abs(y) for _, y in body.foot.sole)

    def path(self, start: Placement, end: Placement, y: float) -> FootPath:
        """The path from one stand to the next: as the parameters have it, or the first other that clears edges.

        Args:
            start: stand before.
            end: stand after.
            y: of the ankle, m.

        Raises:
            ConfigurationError: none of those tried stays off the ground.
        """
        p = self._p
        fraction = min((end.x - start.x) / (2.0 * p.D_s), 1.0)
        path = FootPath(p, self._shape, start, end, fraction)
        if not any(start.x - 0.2 < edge < end.x + 0.2 for edge in p.ground.edges()):
            return path
        deepest = self._depth(path, y)
        swing, way = p.T_c - p.T_d, (p.L_ao or p.D_s) / (2.0 * p.D_s)
        for rise in _RAISES:
            for time, ahead in _SHIFTS:
                if deepest <= _TOLERANCE:
                    return path
                apex = Apex(p.T_m + time * swing, way + ahead, p.H_ao + rise)
                path = FootPath(p, self._shape, start, end, fraction, apex)
                deepest = self._depth(path, y)
        if deepest > _TOLERANCE:
            refuse(
                f"the foot that swings from x = {start.x:.3f} m to {end.x:.3f} m goes {1e3 * deepest:.1f} mm "
                "into the known ground; raise H_ao"
            )
        return path

    def _depth(self, path: FootPath, y: float) -> float:
        """How deep a path goes into the ground, m."""
        ground = self._p.ground
        sides = (y - self._half_width, y, y + self._half_width)
        x, z = path.sole(even(0.0, path.settled, _MOMENTS), self._along)
        places = zip(x.ravel().tolist(), z.ravel().tolist(), strict=True)
        return float(max(ground.at(place, sides) - height for place, height in places))
