"""Walk in a world of your own, in this very process: no second process, no link, no waiting.

python examples/own_scenario.py [FILE.toml]
"""

import math
import sys
from pathlib import Path

from bridge.datasheet import load_body
from bridge.guard import Guard
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from emulator.wear import load_wear
from lab import inprocess
from lab.statistics import RunStatistics
from walker.controller import Controller, WalkOrder
from walker.gait import gait_parameters, make_gait


def main(file: str) -> None:
    """Six dynamic steps on a nominal robot."""
    body, scenario = load_body("nao-v3"), load_scenario(file)
    gait = make_gait("dynamic", gait_parameters("dynamic"), body)
    controller = Controller(body, gait, WalkOrder(steps=6), body.cycle)
    statistics = RunStatistics(seed=1)
    with EmulatedRobot(body, seed=1, wear=load_wear("nominal"), scenario=scenario) as robot:
        inprocess.run(robot, Guard(body), controller, [statistics], most=2000)
    s = statistics.summary(wall_seconds=1.0)
    print(f"{scenario.title}:")
    print(f"{'falls' if s.fell else 'stands'} after {s.steps} steps and {s.distance:.2f} m,", end=" ")
    print(f"torso within {math.degrees(s.torso_max):.1f} deg")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else str(Path(__file__).with_name("polished.toml")))
