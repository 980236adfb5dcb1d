"""Shape of either foot's sole, from the data sheet's left one.

All points in metres, AnkleRoll frame projected to the ground (x forward, y left).
"""

from __future__ import annotations

import numpy as np

from bridge.body.model import Body
from bridge.polygon import convex_hull
from bridge.types import Array, Side


def sole_outline(body: Body, side: Side) -> Array:
    """Outline of a sole as published, counter-clockwise, shape (n, 2). It is not convex: see `sole_hull`."""
    outline = np.array(body.foot.sole)
    if side == "R":
        outline[:, 1] *= -1.0
    x, y = outline.T
    twice_area = x @ np.roll(y, -1) - y @ np.roll(x, -1)
    return outline if twice_area > 0.0 else outline[::-1].copy()


def sole_hull(body: Body, side: Side) -> Array:
    """Convex hull of a sole, which bears load: counter-clockwise from the heel's left corner, (n, 2)."""
    hull = np.array(convex_hull(sole_outline(body, side)))
    return np.roll(hull, -int(np.arctan2(hull[:, 1], hull[:, 0]).argmax()), axis=0)


def foot_centre(body: Body, side: Side) -> Array:
    """Middle of a sole (FM of the thesis, after 2.18), shape (2,)."""
    x, y = body.foot.centre
    return np.array([x, y if side == "L" else -y])
