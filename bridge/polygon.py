"""Convex hull of points in the plane, and a point's margin in it (support polygon: Prenner 2011, 3.1)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

Point = tuple[float, float]


def convex_hull(points: Iterable[Sequence[float]]) -> tuple[Point, ...]:
    """Corners of the convex hull, counter-clockwise, no three in line (Andrew's monotone chain).

    Args:
        points: x and y, m. Points that coincide or lie in line give a hull of one or two corners.

    Raises:
        ValueError: There are no points, or a coordinate is not finite.
    """
    ordered = sorted({(float(x), float(y)) for x, y in points})
    if not ordered:
        raise ValueError("a support polygon needs at least one contact with the ground")
    if not all(math.isfinite(x) and math.isfinite(y) for x, y in ordered):
        raise ValueError("a contact point of the support polygon is not finite")
    if len(ordered) < 3:
        return tuple(ordered)
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return (*lower[:-1], *upper[:-1])


def turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    """Twice the area of the triangle: positive where a, b, c turn left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _chain(ordered: Sequence[Point]) -> list[Point]:
    chain: list[Point] = []
    for point in ordered:
        while len(chain) >= 2 and turn(chain[-2], chain[-1], point) <= 0.0:
            chain.pop()
        chain.append(point)
    return chain


def _distance_to_segment(a: Point, b: Point, point: Point) -> float:
    along_x, along_y = b[0] - a[0], b[1] - a[1]
    x, y = point[0] - a[0], point[1] - a[1]
    square = along_x * along_x + along_y * along_y
    along = min(max((x * along_x + y * along_y) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(x - along * along_x, y - along * along_y)


@dataclass(frozen=True)
class SupportPolygon:
    """A convex polygon on the ground; it may be a line or a point."""

    corners: tuple[Point, ...]
    """Counter-clockwise, m, as `convex_hull` gives them."""

    def margin(self, point: Sequence[float]) -> float:
        """Distance of a point to the polygon's edge, m: positive inside, negative outside.

        The stability margin of the zero moment point. A line or a point has no inside.

        Args:
            point: x and y in the polygon's frame, m (more coordinates are not read).

        Raises:
            ValueError: The point is not finite.
        """
        p = (float(point[0]), float(point[1]))
        if not (math.isfinite(p[0]) and math.isfinite(p[1])):
            raise ValueError("the point whose stability margin is asked for is not finite")
        edges = list(zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True))
        distance = min(_distance_to_segment(a, b, p) for a, b in edges)
        inside = len(edges) > 2 and all(turn(a, b, p) >= 0.0 for a, b in edges)
        return distance if inside else -distance
