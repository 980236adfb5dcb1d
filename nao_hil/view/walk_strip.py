"""A walk as a strip of pictures over its plot, for the README.

`python -m nao_hil.view.walk_strip FILE.png [--gait static] [--wear ideal]`
"""

from __future__ import annotations

import argparse
import math

import matplotlib
import numpy as np
from numpy.typing import NDArray

from bridge.body import load_body
from bridge.guard import Guard
from bridge.messages import TruthFrame, WalkTelemetry
from bridge.recording.observer import Observer
from emulator.engine.values import PinholeCamera
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.in_process import run
from nao_hil.runs.run import RunObserver

matplotlib.use("Agg")
from matplotlib import pyplot as plt

PICTURES = 7
WIDTH, HEIGHT = 300, 520


class Strip(Observer):
    """Observer that takes a picture every so often."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self._robot = robot
        self.frames: list[NDArray[np.uint8]] = []

    def telemetry(self, message: WalkTelemetry) -> None:
        """Take a picture at even distances of time."""
        if message.seq % 100 == 59:
            self.frames.append(picture(self._robot, self._robot.truth()))


def picture(robot: EmulatedRobot, truth: TruthFrame) -> NDArray[np.uint8]:
    """The robot from its right front, shape (height, width, 3)."""
    x, y, _ = truth.torso_position
    camera = PinholeCamera((x + 0.55, y - 0.75, 0.45), (x, y, 0.24), WIDTH, HEIGHT, math.radians(40.0))
    return robot.engine.picture(camera)


def draw(file: str, gait: str, wear: str) -> None:
    """Walk six steps in process and draw them."""
    body = load_body("nao-v3")
    with EmulatedRobot(body, seed=0, wear=load_wear(wear, body)) as robot:
        strip, kept = Strip(robot), RunObserver(body)
        controller = controller_maker(RunConfig(gait=gait, steps=6))(body, body.cycle)
        run(robot, Guard(body), controller, [strip, kept], max_cycles=6000)
    chosen = np.linspace(0, len(strip.frames) - 1, PICTURES).round().astype(int)
    figure = plt.figure(figsize=(12, 7), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.35, 1.0))
    for axes, i in zip(upper.subplots(1, PICTURES), chosen, strict=True):
        axes.imshow(strip.frames[i])
        axes.set_axis_off()
        axes.set_title(f"{(100 * i + 60) * body.cycle:.1f} s", fontsize=9)
    sensors, truth, plan = (kept.run[topic] for topic in ("sensors", "world/truth", "walk/telemetry"))
    loads, zmp = lower.subplots(1, 2)
    loads.plot(sensors["time"], sensors["fsr"][:, :4].sum(axis=1), label="left foot")
    loads.plot(sensors["time"], sensors["fsr"][:, 4:].sum(axis=1), label="right foot")
    loads.set(xlabel="time, s", ylabel="sum of the four FSR, N")
    loads.legend(fontsize=8)
    zmp.plot(truth["time"], truth["zmp"][:, 1], lw=0.6, label="measured (ground truth)")
    zmp.plot(plan["time"], plan["zmp"][:, 1], label="planned")
    zmp.set(xlabel="time, s", ylabel="ZMP, y, m")
    zmp.legend(fontsize=8)
    figure.savefig(file, dpi=90)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("--gait", default="static")
    parser.add_argument("--wear", default="ideal")
    arguments = parser.parse_args()
    draw(arguments.file, arguments.gait, arguments.wear)
