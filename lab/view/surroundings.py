"""The world that a recording was made in, from the scenario beside it."""

from __future__ import annotations

import math
from pathlib import Path

from scipy.spatial.transform import Rotation

from bridge.world import WorldObject, WorldReply
from emulator.scenarios import load_scenario
from emulator.scenarios.model import Scenario
from walker.kinematics.transforms import R_yaw, rotation


def recorded_world(recording: Path) -> WorldReply | None:
    """What stood there at the start, from `scenario.toml` in the recording's folder; None without one."""
    file = recording.parent / "scenario.toml"
    return initial_world(load_scenario(str(file))) if file.is_file() else None


def initial_world(scenario: Scenario) -> WorldReply:
    """The boxes and the floor of a scenario before anything happens.

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
    )
