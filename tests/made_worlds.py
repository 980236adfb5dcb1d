"""A recorded world for tests: robots that stand on a small field."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Final

from bridge.adapters.gamecontroller.referee import Referee, Schedule
from bridge.body import load_body
from bridge.messages import TruthFrame
from bridge.recording.recorder import Recorder
from bridge.types import Vec3
from emulator.engine.settings import SETTINGS
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from emulator.start import build_world
from nao_hil.runs.config import RunConfig
from nao_hil.runs.folder import RunDirectory

PLACES: Final[dict[str, tuple[str, Vec3]]] = {
    "red": ("nao-v4", (0.0, 0.0, 0.0)),
    "blue": ("nao-v5", (0.9, 0.4, 1.5)),
}
"""Body, and place (m, m, rad) of each robot."""


PLAYERS: Final = {"red": (5, 1), "blue": (19, 2)}
"""Team and number of each robot."""


def record_world(folder: Path, cycles: int, game: Schedule | None = None) -> dict[str, TruthFrame]:
    """Record robots that stand, each into its folder, as `nao-hil emulate --world` does.

    Args:
        folder: Of the run.
        cycles: How long.
        game: For a referee; None: there is none.

    Returns:
        The last truth of each.
    """
    scenario = load_scenario("field-small")
    world = build_world("mujoco", SETTINGS, scenario, 0)
    robots = [
        EmulatedRobot(
            load_body(body), seed=0, scenario=scenario, name=name, at=at, player=PLAYERS[name], world=world
        )
        for name, (body, at) in PLACES.items()
    ]
    world.referee = None if game is None else Referee(game, sends=False)
    world.start()
    with ExitStack() as opened:
        recorders = []
        for robot in robots:
            directory = RunDirectory(folder / robot.name)
            directory.write_scenario(scenario)
            recorder = Recorder(directory.recording, RunConfig(robot=robot.body.name))
            recorders.append(opened.enter_context(recorder))
        for _ in range(cycles):
            for robot, recorder in zip(robots, recorders, strict=True):
                recorder.sensors(robot.frame, robot.truth())
            world.advance({})
        last = {robot.name: robot.truth() for robot in robots}
    world.engine.close()
    return last
