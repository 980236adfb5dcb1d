"""In-process emulator cycles per second, beside bare `stepSimulation` of the same model in the same state."""

from __future__ import annotations

import statistics
import time
from typing import Any

from bridge.datasheet import load_body
from emulator.engine import bullet
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear

_BLOCK = 50
"""Cycles per timed block; blocks of both kinds alternate, so that a drifting machine slows both."""


def measure(body_name: str = "nao-v3", wear: str = "ideal", blocks: int = 20) -> dict[str, Any]:
    """Time blocks of full cycles and of bare physics steps in turn, the robot standing.

    Returns:
        Medians: cycles per second of both, their ratio (the share of PyBullet's own step), real-time factor.
    """
    body = load_body(body_name)
    full, bare = [], []
    with EmulatedRobot(body, seed=0, wear=load_wear(wear)) as robot:
        steps = round(body.cycle / robot.world.parameters.step)
        for _ in range(blocks):
            began = time.perf_counter()
            for _ in range(_BLOCK):
                robot.advance(None)
            full.append((time.perf_counter() - began) / _BLOCK)
            # The drives' last torques are gone after one step: the bare floor is a robot that sinks a little.
            began = time.perf_counter()
            for _ in range(steps * 4):
                bullet.stepSimulation(robot.world.client)
            bare.append((time.perf_counter() - began) / 4)
    cycle, floor = statistics.median(full), statistics.median(bare)
    return {
        "body": body_name,
        "wear": wear,
        "cycles_per_second": 1.0 / cycle,
        "bare_cycles_per_second": 1.0 / floor,
        "ratio": floor / cycle,
        "real_time_factor": body.cycle / cycle,
    }
