"""Means of the contact forces on the feet over the physics steps of a cycle.

A servo that gets a new request every cycle makes the contact forces swing within the cycle, by tens of newtons
when it is stiff. A sample of the last step would be wrong in the mean, the centre of pressure by centimetres;
force sensors have filters that see the average.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bridge.types import SIDES, Array, Side, Vec3
from emulator.compiled import compilable, compiled
from emulator.engine.values import FootLoad, GroundContacts
from emulator.vectors import add, rotate_back, scaled

STEEP: Final = 0.5
"""Cosine to the sole's normal below which a contact pushes on the rim of the foot, not on the sole."""


def ground_contacts(
    sums: Array,
    rim: Sequence[tuple[int, Vec3]],
    frames: Array,
    steps: int,
    normal: Vec3,
    touching: frozenset[str],
) -> GroundContacts:
    """All contacts of a cycle.

    Args:
        sums: Of each foot over its contact points and the steps, (2, 7): force on it, world frame, N; its part
            along the sole's normal, N; place of the contact times that part, world frame, N m.
        rim: Foot and place, world frame, m, of each contact on the rim.
        frames: AnkleRoll frames now, (2, 12): origin in the world, m; rotation matrix to the world, row by row.
        steps: Of the cycle, at least 1.
        normal: Of the floor, world frame.
        touching: Other links on the ground.
    """
    means = np.zeros((len(SIDES), 6))
    total, x, y = _means(sums, frames, steps, normal, means)
    loads: dict[Side, FootLoad] = {}
    for i, (fx, fy, fz, pressing, *cop) in enumerate(means.tolist()):
        points = tuple(_local(place, frames[i]) for foot, place in rim if foot == i)
        loads[SIDES[i]] = FootLoad((fx, fy, fz), pressing, (cop[0], cop[1]) if pressing > 0.0 else None, points)
    return GroundContacts(loads, (x / total, y / total) if total > 0.0 else None, touching)


@compiled
def _means(sums: Array, frames: Array, steps: int, normal: Vec3, means: Array) -> Vec3:
    """Mean force, normal force and centre of pressure in the sole frame of each foot, (2, 6), written.

    Returns:
        Sum of the feet's weights, and of their centres of pressure, x and y in the world, times these.
    """
    total = x = y = 0.0
    for i in range(len(sums)):
        for axis in range(3):
            means[i, axis] = sums[i, axis] * (1.0 / steps)
        pressing = sums[i, 3]
        means[i, 3] = pressing / steps
        if pressing > 0.0:
            cop = (sums[i, 4] / pressing, sums[i, 5] / pressing, sums[i, 6] / pressing)
            means[i, 4], means[i, 5], _ = _local(cop, frames[i])
            weight = means[i, 0] * normal[0] + means[i, 1] * normal[1] + means[i, 2] * normal[2]
            total, x, y = total + weight, x + weight * cop[0], y + weight * cop[1]
    return total, x, y


@compilable
def _local(place: Vec3, f: Array) -> Vec3:
    """A place of the world in a frame (12,)."""
    way = add(place, scaled((f[0], f[1], f[2]), -1.0))
    return rotate_back((f[3], f[4], f[5], f[6], f[7], f[8], f[9], f[10], f[11]), way)
