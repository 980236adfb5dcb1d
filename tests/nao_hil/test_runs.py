"""Runs: figures against closed forms, resets under way, standing up first, one engine beside the other."""

from __future__ import annotations

import json
import math
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace
from scipy.spatial.transform import Rotation

from bridge.body import load_body
from bridge.guard import Guard
from bridge.messages import WalkTelemetry
from bridge.motion import MotionPlayer, load_motion
from bridge.recording.playback import read_recording
from bridge.recording.recorder import Recorder
from bridge.rotations import R_yaw
from emulator.robot import EmulatedRobot
from nao_hil.analysis.inspection import inspect
from nao_hil.cli.main import run
from nao_hil.runs import in_process
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig, run_config
from nao_hil.runs.in_process import walk_in_process
from nao_hil.runs.motion import play
from nao_hil.runs.summary import RunStatistics
from nao_hil.runs.walk_figures import FallWatch, HeadingMotion
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
    # the feet are closed by one more, and a foot may tap twice where it lands
    assert 0.75 * expected.steps <= found.steps <= 1.5 * expected.steps
    # From the first lift to the last touch-down: without the shift of weight before, which the walker counts.
    assert expected.speed < found.speed
    # the way has the sway to both sides in it
    assert expected.velocity[0] < found.speed < 1.4 * expected.velocity[0]
    assert found.velocity[0] == pytest.approx(expected.velocity[0], rel=0.1)
    assert found.torso_max > 0.0
    for field in ("distance", "cycles", "frames_sha256", "fell"):
        assert getattr(found, field) == getattr(expected, field)


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


BODY = load_body("nao-v3")
ORDER = WalkOrder(steps=2, settle=0.0)


def walk(robot: EmulatedRobot, recorder: Recorder, statistics: RunStatistics, most: int) -> None:
    gait = make_gait("dynamic", gait_parameters("dynamic"), BODY)
    controller = Controller(BODY, gait, ORDER, BODY.cycle)
    in_process.run(robot, Guard(BODY), controller, [recorder, statistics], most)


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


@pytest.mark.parametrize(("robot", "start"), [("nao-v6", "lie-back"), ("nao-v3", "lie-front")])
def test_onto_its_feet_and_on(robot: str, start: str) -> None:
    summary = walk_in_process(
        run_config(
            None, robot=robot, engine="mujoco", gait="dynamic", start=start, steps=4, seed=21, recover=True
        )
    )
    # it lay from the start: that is no fall; it stands at the end, and has walked what was asked for
    assert (summary.falls, summary.recoveries, summary.steps) == (0, 1, 4)
    assert summary.stands
    assert summary.displacement[0] > 0.1
    assert abs(summary.displacement[2]) < 0.5  # rad; what it turned while it got up is no turn of its walk
    assert summary.speed > 0.0


def test_a_start_of_the_scenario_is_one_of_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A robot that lies gets up; where it may not, the run has failed."""
    file = tmp_path / "lying.toml"
    file.write_text('[start]\npose = "lie-back"\n')
    command = ["up", "--mode", "in-process", "--engine", "mujoco", "--robot", "nao-v6", "--scenario", str(file)]
    command += ["--steps", "2", "--json"]
    for options, code in (([], 0), (["--no-recover"], 1)):
        assert run([*command, *options, "--out", str(tmp_path / str(code))]) == code
        summary = json.loads(capsys.readouterr().out.splitlines()[-1])
        assert (summary["stands"], summary["steps"] > 0) == (not code, not code)


@pytest.mark.parametrize("start", [None, "sit"])
def test_the_documented_nod_moves_the_head_alone(
    start: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (Path(__file__).parents[2] / "docs" / "floor.md").read_text()
    (tmp_path / "nod.toml").write_text(page.partition("```toml\n")[2].partition("```")[0])
    options = ["--robot", "nao-v6", "--engine", "mujoco", *(["--start", start] if start else [])]
    code = run(["motion", str(tmp_path / "nod.toml"), *options, "--json"])
    result = json.loads(capsys.readouterr().out)
    assert result["began"] == result["ended"] == "upright"
    assert result["stands"] is (start is None) and code == int(start is not None)


@pytest.mark.parametrize(("robot", "motion"), [("nao-v3", "stand-up-v3"), ("nao-v6", "stand-up")])
def test_a_robot_that_begins_sitting_stands_up(robot: str, motion: str) -> None:
    with build_robot(RunConfig(robot=robot, engine="mujoco", start="sit", seed=1)) as body:
        result = play(body, motion, MotionPlayer(load_motion(motion), body.body))
    assert result.stands and result.began == result.ended == "upright"


def test_a_robot_on_a_hook_does_not_stand() -> None:
    with build_robot(RunConfig(robot="nao-v6", engine="mujoco", start="hang")) as body:
        result = play(body, "stand-up", MotionPlayer(load_motion("stand-up"), body.body))
    assert not result.stands and result.ended == "upright"
