"""How often does it fall? The same walk with many seeds, each another robot of the same wear; in process.

python examples/batch.py [SEEDS]
"""

import math
import sys

from bridge.datasheet import load_body
from bridge.guard import Guard
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from lab import inprocess
from lab.statistics import RunStatistics, Summary
from walker.controller import Controller, WalkOrder
from walker.gait import gait_parameters, make_gait
from walker.parameters import controller_parameters

BODY, WEAR = load_body("nao-v3"), load_wear("nominal")


def walk(seed: int, torso: str) -> Summary:
    """Ten seconds of the dynamic gait."""
    gait = make_gait("dynamic", gait_parameters("dynamic"), BODY)
    parameters = controller_parameters("dynamic", {"torso": torso})
    controller = Controller(BODY, gait, WalkOrder(duration=10.0), BODY.cycle, parameters)
    statistics = RunStatistics(seed)
    with EmulatedRobot(BODY, seed=seed, wear=WEAR) as robot:
        inprocess.run(robot, Guard(BODY), controller, [statistics], most=1500)
    return statistics.summary(wall_seconds=1.0)


def main(seeds: int) -> None:
    """With and without torso control."""
    for torso in ("none", "robust"):
        walks = [walk(seed, torso) for seed in range(seeds)]
        stand = sum(not w.fell for w in walks)
        worst = max(math.degrees(w.torso_max) for w in walks)
        print(f"torso control {torso}: {stand} of {seeds} stand, torso within {worst:.1f} deg")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 4)
