"""A scenario: the robot's start, the ground with its random terrain, and the events.

Lengths in m, masses in kg, times in s from the first frame. Angles are typed by a person: degrees. Positions
are in the floor frame: origin where the robot starts by default, x in its heading, z along the floor's normal.
"""

from __future__ import annotations

import math
from typing import Annotated, Final

import msgspec
import numpy as np

from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.messages.world import min_tilt_duration
from bridge.messages.world_state import HeightGrid, Terrain, Tile
from bridge.validation import unknown_name
from emulator.scenarios.events import (
    FaultEvent,
    FrictionEvent,
    PendulumEvent,
    PlateEvent,
    PushEvent,
    ScenarioEvent,
    TiltEvent,
)
from emulator.scenarios.field import ScenarioField
from emulator.scenarios.ground import (
    Heightfield,
    PlacedBox,
    PlacedThing,
    ScenarioFloor,
    ScenarioTable,
    Start,
    Tiles,
)

MAX_BOXES: Final = 1000
MAX_THINGS: Final = 100


class Scenario(ScenarioTable, frozen=True, kw_only=True):
    """All there is to a world."""

    title: Annotated[str, msgspec.Meta(max_length=200)] = ""
    """One line for people."""
    floor: ScenarioFloor = ScenarioFloor()
    start: Start = Start()
    charger: bool = False
    """The robot is on its charger's cable: its battery does not run down."""
    boxes: Annotated[tuple[PlacedBox, ...], msgspec.Meta(max_length=MAX_BOXES)] = ()
    things: Annotated[tuple[PlacedThing, ...], msgspec.Meta(max_length=MAX_THINGS)] = ()
    field: ScenarioField | None = None
    tiles: Tiles | None = None
    heightfield: Heightfield | None = None
    pushes: tuple[PushEvent, ...] = ()
    plates: tuple[PlateEvent, ...] = ()
    tilts: tuple[TiltEvent, ...] = ()
    frictions: tuple[FrictionEvent, ...] = ()
    pendulums: tuple[PendulumEvent, ...] = ()
    faults: tuple[FaultEvent, ...] = ()

    @property
    def events(self) -> tuple[ScenarioEvent, ...]:
        """All of them, faults included."""
        return (
            *self.pushes,
            *self.plates,
            *self.tilts,
            *self.frictions,
            *self.pendulums,
            *self.faults,
        )

    def __post_init__(self) -> None:
        """Raises ValueError for events that could never happen, so that no run passes without its disturbance.

        These are two boxes or things of one name, a push of an unknown target, and a floor that turns too fast.
        """
        names = [*(box.name for box in self.objects()), *(thing.name for thing in self.things)]
        if len(set(names)) != len(names):
            raise ValueError(f"two boxes or things have the same name; there are {', '.join(names)}")
        movable = {box.name for box in self.boxes if box.mass > 0.0}
        targets = {"Torso", *INDEX_WITH_MIRROR, *movable} - {"LHand", "RHand"}
        for push in self.pushes:
            if push.target not in targets:
                raise ValueError(f"pushes: {unknown_name('target', push.target, targets)}")
        at, until = (self.floor.roll, self.floor.pitch), 0.0
        for tilt in sorted(self.tilts, key=lambda event: event.time):
            turn = math.radians(max(abs(tilt.roll - at[0]), abs(tilt.pitch - at[1])))
            shortest = min_tilt_duration(turn)
            # a tilt that interrupts another begins part-way, and is checked then
            if tilt.time >= until and tilt.duration < shortest:
                raise ValueError(
                    f"tilts: the turn at {tilt.time:g} s needs a duration of {shortest:.3g} s or more"
                )
            at, until = (tilt.roll, tilt.pitch), tilt.time + tilt.duration

    def objects(self) -> tuple[PlacedBox, ...]:
        """All that can be touched: the boxes, and the goals of the field."""
        return (*(self.field.goals() if self.field is not None else ()), *self.boxes)


def terrain_of(scenario: Scenario, random: np.random.Generator) -> Terrain:
    """The ground of a scenario, uneven or painted.

    Args:
        scenario: The world.
        random: For tiles and heightfields without a seed of their own.
    """
    grid = None if scenario.heightfield is None else height_grid(scenario.heightfield, random)
    field = None if scenario.field is None else scenario.field.painted()
    return Terrain(() if scenario.tiles is None else tiles_of(scenario.tiles, random), grid, field)


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
    placed = []
    for row in range(rows):
        for column in range(columns):
            x = tiles.centre[0] + (column - 0.5 * (columns - 1)) * tiles.edge
            y = tiles.centre[1] + (row - 0.5 * (rows - 1)) * tiles.edge
            if math.hypot(x, y) >= tiles.free:
                placed.append(Tile((x, y), tiles.edge, float(heights[row, column])))
    return tuple(placed)


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
