"""A world that is reset under way begins a new recording and a new sum, those of a robot just started."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from bridge.body import load_body
from bridge.guard import Guard
from bridge.recording.playback import read_recording
from bridge.recording.recorder import Recorder
from emulator.robot import EmulatedRobot
from nao_hil.analysis.inspection import inspect
from nao_hil.runs import in_process as inprocess
from nao_hil.runs.summary import RunStatistics
from walker.controller import Controller, WalkOrder
from walker.gaits import gait_parameters, make_gait

BODY = load_body("nao-v3")
ORDER = WalkOrder(steps=2, settle=0.0)


def walk(robot: EmulatedRobot, recorder: Recorder, statistics: RunStatistics, most: int) -> None:
    gait = make_gait("dynamic", gait_parameters("dynamic"), BODY)
    controller = Controller(BODY, gait, ORDER, BODY.cycle)
    inprocess.run(robot, Guard(BODY), controller, [recorder, statistics], most)


def test_after_a_reset_the_robot_is_as_at_a_start_and_the_sum_goes_on(tmp_path: Path) -> None:
    with EmulatedRobot(BODY, seed=5, engine="mujoco") as robot:
        statistics = RunStatistics(5, "pybullet")
        with Recorder(tmp_path / "frames.mcap", {}) as recorder:
            walk(robot, recorder, statistics, 320)
            before = statistics.summary(wall_seconds=1.0)
            robot.reset()
            walk(robot, recorder, statistics, 2000)
        both = statistics.summary(wall_seconds=1.0)
        assert recorder.paths == [tmp_path / "frames.mcap", tmp_path / "frames-2.mcap"]
    with EmulatedRobot(BODY, seed=5, engine="mujoco") as robot:
        alone = RunStatistics(5, "pybullet")
        with Recorder(tmp_path / "alone.mcap", {}) as recorder:
            walk(robot, recorder, alone, 2000)
    fresh = alone.summary(wall_seconds=1.0)
    assert (both.resets, fresh.steps) == (1, 2)
    for field in ("falls", "steps", "distance", "real_time_factor", "cycles", "cycles_missed"):
        total = getattr(before, field) + getattr(fresh, field)
        assert getattr(both, field) == pytest.approx(total), field
    assert both.torso_max == max(before.torso_max, fresh.torso_max)
    assert (tmp_path / "frames-2.mcap").read_bytes() == (tmp_path / "alone.mcap").read_bytes()
    assert inspect(tmp_path / "frames-2.mcap").frames_sha256 == fresh.frames_sha256 != both.frames_sha256
    for name in ("frames.mcap", "frames-2.mcap"):
        times = [item.time for item in read_recording(tmp_path / name)]
        assert times == sorted(times)


def test_a_fall_before_a_reset_is_not_forgotten() -> None:
    with EmulatedRobot(BODY, seed=5, engine="mujoco") as robot:
        statistics = RunStatistics(5, "pybullet")

        def stand(cycles: int) -> None:
            for _ in range(cycles):
                statistics.sensors(robot.frame, robot.truth())
                robot.advance(None)

        stand(5)
        fallen = replace(robot.truth(), fell=True)
        for seq in (5, 6, 7):  # it lies
            statistics.sensors(replace(robot.frame, seq=seq), replace(fallen, seq=seq))
        robot.reset()
        stand(20)
    summary = statistics.summary(wall_seconds=1.0)
    assert (summary.fell, summary.falls, summary.resets) == (True, 1, 1)
    assert summary.cycles == 7 + 19


def test_what_was_said_before_a_reset_is_not_counted_after_it(tmp_path: Path) -> None:
    with (
        EmulatedRobot(BODY, seed=5, engine="mujoco") as robot,
        Recorder(tmp_path / "frames.mcap", {}) as recorder,
    ):
        gait = make_gait("dynamic", gait_parameters("dynamic"), BODY)
        old = replace(Controller(BODY, gait, ORDER, BODY.cycle).telemetry, seq=700, step=9)
        recorder.sensors(robot.frame, robot.truth())
        recorder.telemetry(old)  # on its way when the robot began anew
        walk(robot, recorder, RunStatistics(5, "pybullet"), 2000)
    assert inspect(tmp_path / "frames.mcap").steps == 2
