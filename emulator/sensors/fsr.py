"""Force sensors of a foot: the ground's push on the sole, distributed among four cells.

The sole is a rigid plate on four equal springs that can only push. Its forces are affine in the cells' places,
which makes them the forces of least norm with the right sum and moments; a cell that would have to pull lets
go, and the other three are then given by statics alone.
"""

from __future__ import annotations

import numpy as np

from bridge.types import Vec2, Vec3

Cells = tuple[float, float, float, float]
NO_LOAD: Cells = (0.0, 0.0, 0.0, 0.0)


class FootForceSensors:
    """The four cells of one foot.

    Args:
        places: FL, FR, RL, RR in the AnkleRoll frame, m (data sheet).
    """

    def __init__(self, places: tuple[Vec3, Vec3, Vec3, Vec3]) -> None:
        xy = [(place[0], place[1]) for place in places]
        statics = np.array([[1.0] * 4, [p[0] for p in xy], [p[1] for p in xy]])
        self._least_norm: list[list[float]] = np.linalg.pinv(statics).tolist()
        self._inner: list[float] = np.linalg.svd(statics)[2][3].tolist()
        """Forces in balance with each other: the one other way to distribute a load."""
        fl, fr, rl, rr = xy
        self._outline = (fl, rl, rr, fr)
        """Counter-clockwise."""

    def distribute(self, force: float, cop: Vec2 | None) -> Cells:
        """Forces on FL, FR, RL, RR along the sole normal, N.

        Their sum is the force; their centre of pressure is the true one where it lies between the cells, else
        the nearest point that does.

        Args:
            force: Total normal force, N.
            cop: True centre of pressure in the sole frame, m; None without load.
        """
        if cop is None or force <= 0.0:
            return NO_LOAD
        x, y = self._nearest_inside(cop)
        plate = [row[0] + row[1] * x + row[2] * y for row in self._least_norm]
        low, high = -float("inf"), float("inf")
        for load, inner in zip(plate, self._inner, strict=True):
            if inner > 1e-12:
                low = max(low, -load / inner)
            elif inner < -1e-12:
                high = min(high, -load / inner)
        shift = min(max(0.0, low), high)
        fl, fr, rl, rr = (
            force * max(0.0, load + shift * inner) for load, inner in zip(plate, self._inner, strict=True)
        )
        return fl, fr, rl, rr

    def _nearest_inside(self, point: Vec2) -> Vec2:
        """The point itself between the cells, else the nearest point of their outline."""
        inside, nearest, smallest = True, point, float("inf")
        for (ax, ay), (bx, by) in zip(self._outline, (*self._outline[1:], self._outline[0]), strict=True):
            ex, ey, px, py = bx - ax, by - ay, point[0] - ax, point[1] - ay
            inside = inside and ex * py - ey * px >= 0.0
            t = min(1.0, max(0.0, (px * ex + py * ey) / (ex * ex + ey * ey)))
            place = (ax + t * ex, ay + t * ey)
            distance = (place[0] - point[0]) ** 2 + (place[1] - point[1]) ** 2
            if distance < smallest:
                nearest, smallest = place, distance
        return point if inside else nearest
