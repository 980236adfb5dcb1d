"""Play games of one against one with a ball over cores or hosts, and count the goals.

python examples/games.py --games 8                            # this machine, a process per core
python examples/games.py --games 40 --scheduler tcp://host:8786

Each robot walks to the ball and dribbles it towards the other goal. A game is a function of its seed.
"""

import argparse
import contextlib
import math
import random
import time

from dask.distributed import Client, as_completed

import nao_hil
from bridge.errors import WalkRefused
from bridge.messages.walk import WalkCommand
from bridge.messages.world import LEAGUE_BALL_MASS, PlaceObject
from bridge.rotations import yaw

GOALS = {"red": 3.0, "blue": -3.0}  # x of the goal that each attacks, m; field-small is 6 m long
BALL = PlaceObject(name="ball", shape="ball", size=(0.1, 0.1, 0.1), mass=LEAGUE_BALL_MASS, at=(0.0, 0.0))
REACH = 0.2  # m behind the ball from which a robot walks through it


def velocity(robot, ball: tuple[float, ...], goal: float) -> tuple[float, float, float]:
    """Walk behind the ball, then through it to the goal: m/s, m/s, rad/s."""
    x, y, heading = *robot.torso_position[:2], yaw(robot.torso_orientation)
    to_goal = math.atan2(-ball[1], goal - ball[0])
    behind = math.remainder(math.atan2(ball[1] - y, ball[0] - x) - to_goal, math.tau)
    aim = (
        ball
        if abs(behind) < 0.4
        else (ball[0] - REACH * math.cos(to_goal), ball[1] - REACH * math.sin(to_goal))
    )
    turn = math.remainder(math.atan2(aim[1] - y, aim[0] - x) - heading, math.tau)
    return 0.2 * max(0.0, math.cos(turn)), 0.0, max(-0.6, min(0.6, turn))


def play(seed: int, seconds: float = 60.0) -> dict:
    """One game; goals of each robot, and seconds that it lay or got up."""
    draw = random.Random(seed)
    down, goals = dict.fromkeys(GOALS, 0.0), dict.fromkeys(GOALS, 0)
    with nao_hil.World("field-small", engine="mujoco") as world:
        for number, (name, goal) in enumerate(GOALS.items()):
            side = -math.copysign(1.0, goal)
            at = (side, draw.uniform(-0.5, 0.5), 0.0 if goal > 0.0 else math.pi)
            world.add("nao-v6", name=name, seed=2 * seed + number, at=at)
        world.send(BALL)
        for name in GOALS:
            world.add_walker(name)
        for cycle in range(round(seconds / world.cycle)):
            world.step()
            truth = world.truth
            for name, robot in truth.robots.items():
                down[name] += robot.fell * world.cycle
            ball = truth.objects["ball"].position
            if abs(ball[0]) > 3.0 or abs(ball[1]) > 2.0:  # out: back to the middle
                goals["red" if ball[0] > 0.0 else "blue"] += abs(ball[0]) > 3.0 and abs(ball[1]) < 0.7
                world.send(BALL)
            elif cycle % 25 == 0:
                for name, robot in truth.robots.items():
                    with contextlib.suppress(WalkRefused):  # it lies
                        order = WalkCommand(op="walk", velocity=velocity(robot, ball, GOALS[name]))
                        world.order(name, order)
    return {"seed": seed, "goals": goals, "down": down}


def main() -> None:
    """Play the games and print each as it ends."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--games", type=int, default=4)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--workers", type=int, help="default: one per core")
    parser.add_argument("--scheduler", help="address of a dask scheduler; default: processes of this machine")
    arguments = parser.parse_args()
    began = time.monotonic()
    here = {"n_workers": arguments.workers, "threads_per_worker": 1, "dashboard_address": None}
    with Client(arguments.scheduler) if arguments.scheduler else Client(**here) as client:
        futures = client.map(play, range(arguments.games), seconds=arguments.seconds)
        for future in as_completed(futures):
            print(future.result())
    print(f"{arguments.games} games in {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main()
