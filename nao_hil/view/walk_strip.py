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
from bridge.messages import SensorFrame, TruthFrame, WalkTelemetry
from bridge.recording.observer import Observer
from emulator.engine.values import PinholeCamera
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.in_process import run

matplotlib.use("Agg")
from matplotlib import pyplot as plt

PICTURES = 7
WIDTH, HEIGHT = 300, 520


class Strip(Observer):
    """Observer that takes a picture every so often and keeps the data of the plot."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self._robot = robot
        self.frames: list[NDArray[np.uint8]] = []
        self.rows: list[tuple[float, ...]] = []
        self.plan: list[tuple[float, float]] = []

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """Keep time, feet loads, torso and ZMP."""
        zmp = truth.zmp or (math.nan, math.nan)
        self.rows.append((frame.time, sum(frame.fsr[:4]), sum(frame.fsr[4:]), *frame.angle, *zmp))

    def telemetry(self, message: WalkTelemetry) -> None:
        """Keep the planned ZMP; take a picture at even distances of time."""
        self.plan.append(message.zmp)
        if len(self.plan) % 100 == 60:
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
        strip = Strip(robot)
        controller = controller_maker(RunConfig(gait=gait, steps=6))(body, body.cycle)
        run(robot, Guard(body), controller, [strip], max_cycles=6000)
    chosen = np.linspace(0, len(strip.frames) - 1, PICTURES).round().astype(int)
    figure = plt.figure(figsize=(12, 7), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.35, 1.0))
    for axes, i in zip(upper.subplots(1, PICTURES), chosen, strict=True):
        axes.imshow(strip.frames[i])
        axes.set_axis_off()
        axes.set_title(f"{(100 * i + 60) * body.cycle:.1f} s", fontsize=9)
    rows = np.array(strip.rows)
    loads, zmp = lower.subplots(1, 2)
    loads.plot(rows[:, 0], rows[:, 1], label="left foot")
    loads.plot(rows[:, 0], rows[:, 2], label="right foot")
    loads.set(xlabel="time, s", ylabel="sum of the four FSR, N")
    loads.legend(fontsize=8)
    plan = np.array(strip.plan)
    zmp.plot(rows[:, 0], rows[:, 6], lw=0.6, label="measured (ground truth)")
    zmp.plot(rows[: len(plan), 0], plan[:, 1], label="planned")
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
