"""Key-frame motions as strips of pictures, for docs/floor.md.

`python -m tests.docs.motion_strip FILE.png NAME... [--robot nao-v6] [--engine pybullet]`
"""

from __future__ import annotations

import argparse
import math
from typing import Final

import matplotlib
import numpy as np
from numpy.typing import NDArray

from bridge.body import Body, load_body
from bridge.motion import MotionPlayer, load_motion
from emulator.engine.catalogue import ENGINES
from emulator.engine.values import PinholeCamera
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from nao_hil.runs.motion import START_POSES, play

matplotlib.use("Agg")
from matplotlib import pyplot as plt

PICTURES: Final = 9
SIZE: Final = 240
PICTURE_INTERVAL: Final = 10
"""Cycles from one picture to the next; not all are drawn."""


def pictures(name: str, body: Body, engine: str) -> list[tuple[float, NDArray[np.uint8]]]:
    """Times (s) and pictures of a motion, from the pose in which it begins to its end."""
    motion = load_motion(name)
    start = START_POSES[motion.begins[0]]
    taken = []
    with EmulatedRobot(body, seed=1, wear=load_wear("nominal"), engine=engine, start=start) as robot:
        if name.startswith("stand-up"):
            before = name.replace("stand-up", "sit-down")
            play(robot, before, MotionPlayer(load_motion(before), body))
        begin = robot.seq

        def watch(now: EmulatedRobot) -> None:
            if (now.seq - begin) % PICTURE_INTERVAL == 0:
                x, y, _ = now.truth().torso_position
                camera = PinholeCamera((x + 0.45, y - 0.9, 0.40), (x, y, 0.22), SIZE, SIZE, math.radians(44.0))
                taken.append((now.time, now.engine.picture(camera)))

        play(robot, name, MotionPlayer(motion, body), watch=watch)
    return [taken[i] for i in np.linspace(0, len(taken) - 1, PICTURES).round().astype(int)]


def draw(file: str, names: list[str], robot: str, engine: str) -> None:
    """Draw a row for each motion."""
    figure, rows = plt.subplots(len(names), PICTURES, figsize=(12, 1.5 * len(names)), squeeze=False)
    for panels, name in zip(rows, names, strict=True):
        for panel, (time, picture) in zip(panels, pictures(name, load_body(robot), engine), strict=True):
            panel.imshow(picture)
            panel.set_axis_off()
            panel.set_title(f"{time:.1f} s", fontsize=7)
        panels[0].set_title(f"{name}, {panels[0].get_title()}", fontsize=7, loc="left")
        panels[0].set_title("")
    figure.tight_layout(pad=0.3)
    figure.savefig(file, dpi=75)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("names", nargs="+")
    parser.add_argument("--robot", default="nao-v6")
    parser.add_argument("--engine", choices=ENGINES, default="pybullet")
    arguments = parser.parse_args()
    draw(arguments.file, arguments.names, arguments.robot, arguments.engine)
