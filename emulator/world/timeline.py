"""From a scenario to the world, its ground and its events: degrees become radians here."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from bridge.messages.world import PlateUnderFoot, Push, SetFriction, SwingPendulum, TiltFloor
from bridge.messages.world_state import Terrain
from emulator.engine.base import Engine
from emulator.poses import Pose
from emulator.scenarios.model import Scenario, terrain_of
from emulator.world.events import WorldEvent
from emulator.world.world import SURFACES, World

_FOUNDATION = 0.02
"""Depth of a tile below the floor, m: no tile is so thin that a foot could slip through between two steps."""


def lay_terrain(world: World, terrain: Terrain) -> None:
    """Fix tiles and heightfield on the floor of a world."""
    scene = world.engine.scene
    if terrain.grid is not None:
        grid = terrain.grid
        heights = np.array(grid.heights, dtype=np.float64)
        scene.add_heightfield("terrain grid", heights, grid.spacing, (*grid.centre, 0.0))
    for number, tile in enumerate(terrain.tiles):
        size = (tile.edge, tile.edge, tile.height + _FOUNDATION)
        pose = Pose((*tile.at, size[2] / 2.0 - _FOUNDATION))
        scene.add_box(f"terrain tile {number}", size, pose)
    world.terrain = terrain


def build_world(engine: Engine, scenario: Scenario, random: np.random.Generator) -> World:
    """The world of a scenario as it is before anything happens.

    Args:
        engine: With an empty world.
        scenario: The world to build.
        random: For tiles and heightfields without a seed of their own.
    """
    floor = scenario.floor
    surface = SURFACES[floor.surface]
    if floor.friction is not None:
        surface = replace(surface, friction=floor.friction)
    if floor.stiffness is not None:
        surface = replace(surface, stiffness_per_area=floor.stiffness)
    world = World(engine, surface, math.radians(floor.roll), math.radians(floor.pitch))
    lay_terrain(world, terrain_of(scenario, random))
    for box in scenario.boxes:
        world.add_box(
            box.name,
            box.size,
            box.at,
            math.radians(box.yaw),
            height=box.height,
            mass=box.mass,
            friction=box.friction,
        )
    for thing in scenario.things:
        yaw = math.radians(thing.yaw)
        world.put_thing(thing.name, thing.kind, thing.at, yaw, thing.height, thing.size)
    return world


def timeline(scenario: Scenario) -> list[tuple[float, WorldEvent]]:
    """What happens when (s), as the commands that would do it live; events of one time in the order here."""
    events: list[tuple[float, WorldEvent]] = []
    for change in scenario.frictions:
        events.append((change.time, SetFriction(friction=change.friction)))
    for tilt in scenario.tilts:
        command = TiltFloor(
            roll=math.radians(tilt.roll), pitch=math.radians(tilt.pitch), duration=tilt.duration
        )
        events.append((tilt.time, command))
    for plate in scenario.plates:
        events.append(
            (
                plate.time,
                PlateUnderFoot(
                    foot=plate.foot,
                    size=plate.size,
                    shift=plate.shift,
                    yaw=math.radians(plate.yaw),
                    name=plate.name,
                ),
            )
        )
    for push in scenario.pushes:
        impulse = push.impulse_vector()
        events.append((push.time, Push(impulse=impulse, duration=push.duration, target=push.target)))
    for strike in scenario.pendulums:
        events.append(
            (
                strike.time,
                SwingPendulum(
                    mass=strike.mass,
                    length=strike.length,
                    angle=math.radians(strike.angle),
                    direction=math.radians(strike.direction),
                    height=strike.height,
                ),
            )
        )
    return events
