"""A walk in process: the robot's cycle, the walker's tick, and their two floors.

The floors are the engine's own steps of a second, standing robot, and the inverse kinematics of both legs.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, Final

import msgspec

from bridge.body import Body
from bridge.body.inverse_kinematics import FootPose, solve_legs
from bridge.body.kinematics import foot_in_torso
from emulator.engine.catalogue import ENGINES
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig
from tests.bench.cycles import bare_cycle

STANDING: Final = (0.0, 0.0, -0.5, 1.0, -0.5, 0.0)
"""Angles of a leg, rad."""
FIRST_CYCLES: Final = 300
"""Cycles before the first block: the robot approaches its stand, and makes its first steps."""
BLOCKS: Final = 15
BLOCK_CYCLES: Final = 100
"""Cycles of a block."""


def measure() -> dict[str, Any]:
    """`measure_one` of the gait `omni` at 0.2 m/s, a nominal V6, on each engine."""
    settings = RunConfig(robot="nao-v6", gait="omni", velocity=(0.2, 0.0, 0.0), steps=0)  # without an end
    return {
        engine: measure_one(msgspec.structs.replace(settings, engine=engine))
        for engine in ENGINES
        if find_spec(engine) is not None
    }


def measure_one(settings: RunConfig) -> dict[str, Any]:
    """Blocks of a walk's cycles, and in turns with them blocks of the floors; each part is timed.

    Returns:
        Median and 99th percentile of the tick, medians of the robot's cycle, of the engine's own steps and of
        `solve_legs`, all in s; real time over the time of robot and tick, and over that of the engine's steps.
    """
    spent: dict[str, list[float]] = {"tick": [], "robot": [], "engine": [], "legs": []}

    def timed(name: str, function: Callable[..., Any], *arguments: Any) -> Any:
        began = time.perf_counter()
        result = function(*arguments)
        spent[name].append(time.perf_counter() - began)
        return result

    with build_robot(settings) as robot, build_robot(settings) as standing:
        body: Body = robot.body
        controller = controller_maker(settings)(body, body.cycle)
        feet = [FootPose.of(foot_in_torso(body, side, STANDING)) for side in ("L", "R")]
        for _ in range(FIRST_CYCLES):
            robot.advance(controller.tick(robot.frame))
        for _ in range(BLOCKS):
            for _ in range(BLOCK_CYCLES):
                timed("robot", robot.advance, timed("tick", controller.tick, robot.frame))
            for _ in range(BLOCK_CYCLES):
                standing.advance(None)  # its drives hold it; not timed
                timed("engine", bare_cycle, standing)
                timed("legs", solve_legs, body, *feet)
    medians = {name: statistics.median(values) for name, values in spent.items()}
    cycle = statistics.median(a + b for a, b in zip(spent["robot"], spent["tick"], strict=True))
    return {
        "tick_p50": medians["tick"],
        "tick_p99": statistics.quantiles(spent["tick"], n=100)[98],
        "robot_p50": medians["robot"],
        "engine_p50": medians["engine"],
        "inverse_kinematics_p50": medians["legs"],
        "real_time_factor": body.cycle / cycle,
        "engine_real_time_factor": body.cycle / medians["engine"],
    }
