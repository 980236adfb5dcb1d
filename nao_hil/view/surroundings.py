"""The world of a recording, from its scenario, and footprints."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bridge.body.kinematics import FloatingBase
from bridge.messages.world_state import Terrain, WorldObject, WorldReply
from bridge.planar import Pose2D
from bridge.recording.playback import recorded_config
from bridge.rotations import R_yaw, heading, rotation
from bridge.types import SIDES, Array, Side
from emulator.scenarios import load_scenario
from emulator.scenarios.model import Scenario, terrain_of
from nao_hil.analysis.diagnosis import Balance
from walker.estimation.odometry import on_ground

Kind = Literal["planned", "made"]
SAME_OUTLINE_DISTANCE: Final = 0.004
"""An outline this close to the last one of its kind is the same, m."""


class Footprint(NamedTuple):
    """One outline."""

    kind: Kind
    corners: Array
    """World frame, shape (n, 2), m."""


class Footprints:
    """Follows the feet of a robot."""

    def __init__(self, kinematics: FloatingBase) -> None:
        self._kinematics = kinematics
        self._down: dict[tuple[Kind, Side], bool] = {}
        self._last: dict[Kind, Array] = {}

    def update(self, balance: Balance) -> list[Footprint]:
        """Footprints that the next moment adds."""
        found: list[Footprint] = []
        for side in SIDES:
            foot = balance.best.robot.feet[side]
            at = Pose2D(float(foot[0, 3]), float(foot[1, 3]), heading(foot))
            found += self._touch("made", side, balance.best.contacts.of(side), at)
            if balance.plan is not None:
                found += self._touch("planned", side, balance.plan.lift[side] < 1e-4, balance.plan.soles[side])
        return found

    def _touch(self, kind: Kind, side: Side, down: bool, at: Pose2D) -> list[Footprint]:
        before, self._down[kind, side] = self._down.get((kind, side), False), down
        if not down or before:
            return []
        corners = (self._kinematics.soles[side] @ on_ground(at).T)[:, :2]
        last = self._last.get(kind)
        if last is not None and np.abs(last[0] - corners[0]).max() < SAME_OUTLINE_DISTANCE:
            return []
        self._last[kind] = corners
        return [Footprint(kind, corners)]


def recorded_world(recording: Path) -> WorldReply | None:
    """Objects at the start, from `scenario.toml` in the recording's folder; None without one."""
    file = recording.parent / "scenario.toml"
    if not file.is_file():
        return None
    config = recorded_config(recording)
    return initial_world(load_scenario(str(file)), config.get("seed", 0) if isinstance(config, dict) else 0)


def initial_world(scenario: Scenario, seed: int) -> WorldReply:
    """Boxes, floor and terrain of a scenario before anything happens to a robot of this seed.

    A box without a height is drawn on the floor, also where it is on another one.
    """
    floor = scenario.floor
    roll, pitch = math.radians(floor.roll), math.radians(floor.pitch)
    R_floor = rotation(roll, pitch, 0.0)
    objects = []
    for box in scenario.objects():
        middle = R_floor @ (*box.at, (box.height or 0.0) + 0.5 * box.size[2])
        R = R_floor @ R_yaw(math.radians(box.yaw))
        x, y, z, w = (float(q) for q in Rotation.from_matrix(R).as_quat())
        objects.append(
            WorldObject(
                name=box.name,
                shape=box.shape,
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


_SQUARE: Final = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))


_SIDES_AND_TOP: Final = np.array(
    [[4, 5, 6], [4, 6, 7]]
    + [[[a, b, b + 4], [a, b + 4, a + 4]][k] for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for k in (0, 1)]
)
"""Faces of a tile whose lower corners are 0 to 3 and upper ones 4 to 7, outward."""


def terrain_meshes(terrain: Terrain) -> list[tuple[Array, NDArray[np.int64]]]:
    """Vertices (n, 3), m, floor frame, and faces (m, 3) of all tiles in one mesh, and of the heights."""
    meshes = []
    if terrain.tiles:
        corners = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in _SQUARE])
        scale = np.array([(tile.edge, tile.edge, tile.height) for tile in terrain.tiles])
        at = np.array([(*tile.at, 0.0) for tile in terrain.tiles])
        vertices = (corners[None] * scale[:, None] + at[:, None]).reshape(-1, 3)
        faces = (_SIDES_AND_TOP[None] + len(corners) * np.arange(len(at))[:, None, None]).reshape(-1, 3)
        meshes.append((vertices, faces))
    if terrain.grid is not None:
        z = np.array(terrain.grid.heights)
        rows, columns = z.shape
        x = terrain.grid.centre[0] + terrain.grid.spacing * (np.arange(columns) - 0.5 * (columns - 1))
        y = terrain.grid.centre[1] + terrain.grid.spacing * (np.arange(rows) - 0.5 * (rows - 1))
        vertices = np.stack([*np.meshgrid(x, y), z], axis=-1).reshape(-1, 3)
        first = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
        lower = np.column_stack([first, first + 1, first + columns])
        upper = np.column_stack([first + 1, first + columns + 1, first + columns])
        meshes.append((vertices, np.vstack([lower, upper])))
    return meshes
