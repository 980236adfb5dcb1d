"""The world that a recording was made in, from the scenario beside it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from bridge.messages.world_state import WorldObject, WorldReply
from bridge.recording.playback import recorded_config
from bridge.rotations import R_yaw, rotation
from emulator.scenarios import load_scenario
from emulator.scenarios.model import Scenario
from emulator.world.terrain import terrain_of


def recorded_world(recording: Path) -> WorldReply | None:
    """What stood there at the start, from `scenario.toml` in the recording's folder; None without one."""
    file = recording.parent / "scenario.toml"
    if not file.is_file():
        return None
    config = recorded_config(recording)
    return initial_world(load_scenario(str(file)), config.get("seed", 0) if isinstance(config, dict) else 0)


def initial_world(scenario: Scenario, seed: int) -> WorldReply:
    """Boxes, floor and terrain of a scenario before anything happens to a robot of this seed.

    A box without a height is drawn on the floor, also where it lies on another one.
    """
    floor = scenario.floor
    roll, pitch = math.radians(floor.roll), math.radians(floor.pitch)
    R_floor = rotation(roll, pitch, 0.0)
    objects = []
    for box in scenario.boxes:
        middle = R_floor @ (*box.at, (box.height or 0.0) + 0.5 * box.size[2])
        R = R_floor @ R_yaw(math.radians(box.yaw))
        x, y, z, w = (float(q) for q in Rotation.from_matrix(R).as_quat())
        objects.append(
            WorldObject(
                name=box.name,
                size=box.size,
                position=(float(middle[0]), float(middle[1]), float(middle[2])),
                orientation=(x, y, z, w),
                mass=box.mass,
            )
        )
    return WorldReply(
        text="",
        seq=0,
        time=0.0,
        paused=False,
        floor=(roll, pitch),
        friction=floor.friction or 0.0,
        objects=tuple(objects),
        faults=(),
        terrain=terrain_of(scenario, np.random.default_rng(seed).spawn(2)[0]),  # as the robot draws it
    )
