"""Terrain of a scenario: random tiles and heightfields, drawn from a generator without an engine."""

from __future__ import annotations

import math

import numpy as np

from bridge.messages.world_state import HeightGrid, Terrain, Tile
from emulator.scenarios.ground import Heightfield, Tiles
from emulator.scenarios.model import Scenario


def terrain_of(scenario: Scenario, random: np.random.Generator) -> Terrain:
    """The ground of a scenario that is not flat.

    Args:
        scenario: The world.
        random: For tiles and heightfields without a seed of their own.
    """
    grid = None if scenario.heightfield is None else height_grid(scenario.heightfield, random)
    return Terrain(() if scenario.tiles is None else tiles_of(scenario.tiles, random), grid)


def tiles_of(tiles: Tiles, random: np.random.Generator) -> tuple[Tile, ...]:
    """Square tiles of random heights, equally likely from 0 to the maximum.

    A round place about the start stays free, so that the robot begins on the floor.

    Args:
        tiles: Their numbers.
        random: For tiles without a seed of their own.
    """
    if tiles.seed is not None:
        random = np.random.default_rng(tiles.seed)
    columns, rows = (max(1, round(length / tiles.edge)) for length in tiles.area)
    heights = random.uniform(0.0, tiles.height, (rows, columns))
    found = []
    for row in range(rows):
        for column in range(columns):
            x = tiles.centre[0] + (column - 0.5 * (columns - 1)) * tiles.edge
            y = tiles.centre[1] + (row - 0.5 * (rows - 1)) * tiles.edge
            if math.hypot(x, y) >= tiles.free:
                found.append(Tile((x, y), tiles.edge, float(heights[row, column])))
    return tuple(found)


def height_grid(field: Heightfield, random: np.random.Generator) -> HeightGrid:
    """The heights as they are given, or random ones.

    Args:
        field: Its numbers.
        random: For a field without a seed of its own.
    """
    if field.heights:
        return HeightGrid(field.centre, field.spacing, field.heights)
    if field.seed is not None:
        random = np.random.default_rng(field.seed)
    columns, rows = (max(2, round(length / field.spacing) + 1) for length in field.area)
    heights = random.uniform(0.0, field.roughness, (rows, columns))
    return HeightGrid(field.centre, field.spacing, tuple(tuple(row) for row in heights.tolist()))
