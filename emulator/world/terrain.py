"""Ground that is not flat: random tiles and heightfields, fixed on the floor."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from emulator.engine import bullet
from emulator.scenarios.model import Heightfield, Tiles
from emulator.world.world import World

_FOUNDATION = 0.02
"""Depth of a tile below the floor, m: no tile is so thin that a foot could slip through between two steps."""


def lay_tiles(world: World, tiles: Tiles, random: np.random.Generator) -> None:
    """Square tiles of random heights, equally likely from 0 to the largest.

    A round place about the start stays free, so that the robot begins on the floor.
    """
    if tiles.seed is not None:
        random = np.random.default_rng(tiles.seed)
    columns, rows = (max(1, round(length / tiles.edge)) for length in tiles.area)
    heights = random.uniform(0.0, tiles.height, (rows, columns))
    for row in range(rows):
        for column in range(columns):
            x = tiles.centre[0] + (column - 0.5 * (columns - 1)) * tiles.edge
            y = tiles.centre[1] + (row - 0.5 * (rows - 1)) * tiles.edge
            if math.hypot(x, y) < tiles.free:
                continue
            half = (tiles.edge / 2.0, tiles.edge / 2.0, (heights[row, column] + _FOUNDATION) / 2.0)
            shape = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half, physicsClientId=world.client)
            world.add_fixed(shape, (x, y, half[2] - _FOUNDATION))


def lay_heightfield(world: World, field: Heightfield, random: np.random.Generator) -> None:
    """A grid of heights with triangles between."""
    if field.heights:
        heights: NDArray[np.float64] = np.array(field.heights, dtype=np.float64)
    else:
        if field.seed is not None:
            random = np.random.default_rng(field.seed)
        columns, rows = (max(2, round(length / field.spacing) + 1) for length in field.area)
        heights = random.uniform(0.0, field.roughness, (rows, columns))
    rows, columns = heights.shape
    shape = bullet.createCollisionShape(
        bullet.GEOM_HEIGHTFIELD,
        meshScale=(field.spacing, field.spacing, 1.0),
        heightfieldTextureScaling=1.0,
        heightfieldData=heights.ravel().tolist(),
        # PyBullet's rows are the points along x, whose index runs fastest.
        numHeightfieldRows=columns,
        numHeightfieldColumns=rows,
        physicsClientId=world.client,
    )
    # PyBullet puts the middle between the lowest and the highest point at the body's origin.
    middle = 0.5 * float(heights.min() + heights.max())
    world.add_fixed(shape, (field.centre[0], field.centre[1], middle))
