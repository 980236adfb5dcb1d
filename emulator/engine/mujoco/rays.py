"""Rays through MuJoCo's world as machine code."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from emulator.compiled import compiled
from emulator.engine.mujoco.native import mj_ray
from emulator.engine.mujoco.shapes import ROBOT_GROUP
from emulator.engine.mujoco.simulation import Simulation
from emulator.engine.values import RayHit

Vector = NDArray[np.float64]
_LAYERS: Final = 8
"""Surfaces that a ray leaves from inside before it is given up."""
_ON: Final = 1e-6
"""How far behind a surface a ray goes on, as a fraction of its length."""


def hits(simulation: Simulation, starts: Vector, ends: Vector, seen: Sequence[int]) -> list[RayHit]:
    """The first surface of each ray that it meets from outside.

    Args:
        simulation: The world.
        starts: World frame, (n, 3), m.
        ends: One for each start, likewise.
        seen: Groups of the geoms that stop a ray.
    """
    groups = np.zeros(6, dtype=np.uint8)
    groups[list(seen)] = 1
    geoms, found = np.full(len(starts), -1, dtype=np.int32), np.zeros((len(starts), 7))
    model, data = simulation.model, simulation.now
    _cast(model._address, data._address, groups, starts, ends, geoms, found)
    result = []
    robots = (model.geom_group[geoms] == ROBOT_GROUP).tolist()
    for geom, robot, end, hit in zip(geoms.tolist(), robots, ends.tolist(), found.tolist(), strict=True):
        fraction, x, y, z, nx, ny, nz = hit
        if geom < 0:
            result.append(RayHit("nothing", 1.0, (end[0], end[1], end[2]), (0.0, 0.0, 0.0)))
        else:
            result.append(RayHit("robot" if robot else "scene", fraction, (x, y, z), (nx, ny, nz)))
    return result


@partial(compiled, nogil=True)
def _cast(
    model: int,
    data: int,
    groups: NDArray[np.uint8],
    starts: Vector,
    ends: Vector,
    geoms: NDArray[np.int32],
    found: Vector,
) -> None:
    # `found`: fraction of the way, point, normal
    geom, normal, way, begin = np.zeros(1, dtype=np.int32), np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(len(starts)):
        gone = 0.0
        for axis in range(3):
            way[axis] = ends[i, axis] - starts[i, axis]
        for _ in range(_LAYERS):
            for axis in range(3):
                begin[axis] = starts[i, axis] + gone * way[axis]
            places = (
                begin.ctypes.data,
                way.ctypes.data,
                groups.ctypes.data,
                geom.ctypes.data,
                normal.ctypes.data,
            )
            far = mj_ray(model, data, places[0], places[1], places[2], 1, -1, places[3], places[4])
            if far < 0.0 or gone + far > 1.0:
                break
            gone += far
            if normal[0] * way[0] + normal[1] * way[1] + normal[2] * way[2] < 0.0:
                geoms[i] = geom[0]
                found[i, 0] = gone
                for axis in range(3):
                    found[i, 1 + axis] = starts[i, axis] + gone * way[axis]
                    found[i, 4 + axis] = normal[axis]
                break
            gone += _ON  # it left a shape from inside
