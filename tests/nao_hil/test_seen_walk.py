"""The summary of a walk that its controller says nothing of."""

from __future__ import annotations

import pytest

from bridge.body import load_body
from bridge.guard import Guard
from bridge.messages import WalkTelemetry
from emulator.robot import EmulatedRobot
from nao_hil.runs import in_process
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.summary import RunStatistics
from walker.controller import Controller, WalkOrder
from walker.gaits import gait_parameters, make_gait


class Deaf(RunStatistics):
    """As for a foreign client: no telemetry."""

    def telemetry(self, message: WalkTelemetry) -> None:
        pass


def test_what_is_seen_of_a_walk_is_what_its_walker_says() -> None:
    body = load_body("nao-v3")
    gait = make_gait("dynamic", gait_parameters("dynamic"), body)
    controller = Controller(body, gait, WalkOrder(steps=8, settle=0.0), body.cycle)
    told, seen = RunStatistics(3, "pybullet"), Deaf(3, "pybullet")
    with EmulatedRobot(body, seed=3, engine="mujoco") as robot:
        in_process.run(robot, Guard(body), controller, [told, seen], 1500)
    expected, found = told.summary(1.0), seen.summary(1.0)
    assert expected.steps == 8
    assert abs(found.steps - expected.steps) <= 2  # the feet are closed by one more, and one may tap twice
    # From the first lift to the last touch-down: without the shift of weight before, which the walker counts.
    assert expected.speed < found.speed
    # the way has the sway to both sides in it
    assert expected.velocity[0] < found.speed < 1.4 * expected.velocity[0]
    assert found.velocity[0] == pytest.approx(expected.velocity[0], rel=0.1)
    assert found.torso_max > 0.0
    for field in ("distance", "cycles", "frames_sha256", "fell"):
        assert getattr(found, field) == getattr(expected, field)


def test_speed_is_way_over_time_where_the_walk_goes_in_a_circle() -> None:
    body = load_body("nao-v6")
    told = RunStatistics(0, "mujoco")
    circle = RunConfig(robot="nao-v6", gait="omni", velocity=(0.15, 0.0, 0.8), steps=60)
    controller = controller_maker(circle)(body, body.cycle)
    with EmulatedRobot(body, seed=0, engine="mujoco") as robot:
        in_process.run(robot, Guard(body), controller, [told], 2500)
    summary = told.summary(1.0)
    assert not summary.fell and summary.steps == 60
    # A circle of 0.19 m radius: it never gets farther than its diameter, and goes on at its speed.
    assert summary.distance < 0.45 < summary.way
    # start and stop included; by displacement it would be below 0.03
    assert summary.speed == pytest.approx(0.15, rel=0.3)
