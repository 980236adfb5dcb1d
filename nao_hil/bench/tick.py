"""Time of the walker's tick, beside the inverse kinematics of both legs alone."""

from __future__ import annotations

import statistics
import time
from typing import Any

from bridge.body import load_body
from emulator.robot import EmulatedRobot
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from walker.model.inverse import solve_legs
from walker.model.leg import foot_in_torso


def measure(gait: str = "static", cycles: int = 1500) -> dict[str, Any]:
    """Walk in process and time each tick.

    Returns:
        Median and 99th percentile of the tick, s, and the median of `solve_legs` on a standing pose.
    """
    body = load_body("nao-v3")
    controller = controller_maker(RunConfig(gait=gait, steps=0))(body, body.cycle)
    ticks = []
    with EmulatedRobot(body, seed=0) as robot:
        for _ in range(cycles):
            frame = robot.frame
            began = time.perf_counter()
            command = controller.tick(frame)
            ticks.append(time.perf_counter() - began)
            robot.advance(command)
    standing = (0.0, 0.0, -0.5, 1.0, -0.5, 0.0)
    left, right = foot_in_torso(body, "L", standing), foot_in_torso(body, "R", standing)
    floor = []
    for _ in range(2000):
        began = time.perf_counter()
        solve_legs(body, left, right)
        floor.append(time.perf_counter() - began)
    ticks.sort()
    return {
        "gait": gait,
        "tick_p50": ticks[len(ticks) // 2],
        "tick_p99": ticks[int(0.99 * len(ticks))],
        "inverse_kinematics_p50": statistics.median(floor),
    }
