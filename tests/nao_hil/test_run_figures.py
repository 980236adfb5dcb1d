"""Figures of a run: falls, steps and velocity, against motions with a closed form."""

from __future__ import annotations

import math

import msgspec
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import load_body
from bridge.guard import Guard
from bridge.messages import Notice, WalkTelemetry
from bridge.rotations import R_yaw
from emulator.robot import EmulatedRobot
from nao_hil.runs import in_process
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.summary import RunStatistics
from nao_hil.runs.walk_figures import SETTLING, FallWatch, HeadingMotion
from tests.frames import walk_telemetry
from walker.controller import Controller, WalkOrder
from walker.gaits import gait_parameters, make_gait


def says(state: str) -> WalkTelemetry:
    return walk_telemetry(1, state=state, phase="stand")


def test_a_robot_that_began_lying_falls_once_it_has_stood() -> None:
    watch = FallWatch()
    assert [watch.update(down=down) for down in (True, True, False, True, True)] == [False] * 3 + [True, False]
    watch.restart()
    assert not watch.update(down=True)


@pytest.mark.parametrize(
    ("state", "falls"), [("walk", True), ("stand", True), ("motion", False), ("rest", False)]
)
def test_going_down_in_a_motion_or_at_rest_is_no_fall(state: str, falls: bool) -> None:
    watch = FallWatch()
    watch.update(down=False)
    watch.telemetry(says(state))
    assert watch.update(down=True) == falls


def test_a_robot_that_its_guard_sits_down_has_not_fallen() -> None:
    watch = FallWatch()
    watch.update(down=False)
    watch.notice(Notice(seq=1, level="info", code="guard-sit", text=""))
    assert not watch.update(down=True)
    watch.update(down=False)
    watch.notice(Notice(seq=1, level="info", code="guard-active", text=""))
    assert watch.update(down=True)


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
    circle = RunConfig(robot="nao-v6", gait="omni", velocity=(0.15, 0.0, 0.8), steps=40)
    controller = controller_maker(circle)(body, body.cycle)
    with EmulatedRobot(body, seed=0, engine="mujoco") as robot:
        in_process.run(robot, Guard(body), controller, [told], 1700)
    summary = told.summary(1.0)
    assert not summary.fell and summary.steps == 40
    # A circle of 0.19 m radius: it never gets farther than its diameter, and goes on at its speed.
    assert summary.distance < 0.45 < summary.way
    # start and stop included; by displacement it would be below 0.03
    assert summary.speed == pytest.approx(0.15, rel=0.3)


class Truth(msgspec.Struct):
    time: float
    torso_position: tuple[float, float, float]
    torso_orientation: tuple[float, float, float, float]


def truth(time, x, y, yaw):
    quaternion = tuple(Rotation.from_matrix(R_yaw(yaw)).as_quat())
    return Truth(time, (x, y, 0.3), quaternion)


@pytest.mark.parametrize("turn", [0.0, 0.7, -1.5])
def test_motion_on_a_circle_has_a_constant_velocity(turn):
    """A body that goes at (u, v) in its own axes and turns at w: its place is the integral in closed form."""
    u, v, motion = 0.2, -0.05, HeadingMotion()
    motion.begin(0.0)
    for k in range(1001):
        t = 0.01 * k
        s, c = (math.sin(turn * t) / turn, (1.0 - math.cos(turn * t)) / turn) if turn else (t, 0.0)
        motion.add(truth(t, u * s - v * c, u * c + v * s, turn * t))
    assert motion.velocity == pytest.approx((u, v, turn), abs=1e-5)
    assert motion.turned == pytest.approx(10.0 * turn, abs=1e-9)


def test_the_beginning_and_what_follows_the_end_do_not_count():
    motion = HeadingMotion()
    motion.begin(1.0)
    x = 0.0
    for k in range(800):
        t = 0.01 * k
        motion.add(truth(t, x, 0.0, 0.0))
        x += 0.01 * (0.3 if 1.0 + SETTLING <= t < 5.0 else 9.0)
        if k == 499:
            motion.end()
    assert motion.velocity[0] == pytest.approx(0.3, abs=1e-6)
