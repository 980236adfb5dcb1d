"""Comparison of a recorded robot with the emulated one: its measures, its CSV, and what it finds."""

from __future__ import annotations

import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.recording.recorder import Recorder
from emulator.wear import load_wear
from nao_hil.arguments import actuator_frame
from nao_hil.cli.main import run
from nao_hil.identification import measures
from nao_hil.identification.comparison_run import compare_recording
from nao_hil.identification.recorded import read_signals
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import run_config
from nao_hil.runs.run import load

CYCLE = 0.01
HEAD = "time,command.LKneePitch,position.LKneePitch"
TIME = np.arange(0.0, 20.0, CYCLE)


@pytest.mark.parametrize("lag", [0.024, 0.037])
def test_the_delay_of_a_shifted_chirp_is_its_shift(lag: float) -> None:
    def chirp(time: np.ndarray) -> np.ndarray:
        return 0.2 * np.sin(2.0 * np.pi * (0.3 + 0.05 * time) * time)

    found = measures.delay(chirp(TIME), chirp(TIME - lag), CYCLE)
    assert found == pytest.approx(lag, abs=1e-3)
    assert measures.delay(np.zeros_like(TIME), chirp(TIME), CYCLE) is None


def test_the_hysteresis_of_a_play_is_its_width() -> None:
    command = 0.3 * (2.0 * np.abs((TIME / 10.0) % 1.0 * 2.0 - 1.0) - 1.0)
    position, width = np.empty_like(command), 0.02
    held = command[0]
    for k, asked in enumerate(command):
        held = min(max(held, asked - width / 2.0), asked + width / 2.0)
        position[k] = held
    assert measures.hysteresis(command, position, CYCLE, 0.0) == pytest.approx(width, rel=0.02)


def knee_recording(folder: Path, backlash: float) -> Path:
    """Six seconds of a hanging robot that bends its left knee; the backlash of its knees is given, rad."""
    wear = load_wear("nominal", load_body("nao-v3"))
    servo = msgspec.structs.replace(
        wear.servo, backlash=msgspec.structs.replace(wear.servo.backlash, KneePitch=backlash)
    )
    settings = run_config(None, engine="mujoco", start="hang", seed=11)
    file = folder / "frames.mcap"
    with (
        build_robot(settings, wear=msgspec.structs.replace(wear, servo=servo)) as robot,
        Recorder(file, settings) as recorder,
    ):
        rest = np.array(robot.frame.position)
        for k in range(600):
            recorder.sensors(robot.frame, robot.truth())
            rest[INDEX["LKneePitch"]] = 0.3 * (1.0 - math.cos(2.0 * math.pi * k * CYCLE / 3.0))
            command = actuator_frame(robot.seq, rest, 1.0)
            recorder.command(command)
            robot.advance(command)
        recorder.sensors(robot.frame, robot.truth())
    return file


def as_csv(file: Path, target: Path) -> None:
    """The same recording as another program would write it down."""
    recording = load(file)
    sensors, actuators = recording["sensors"], recording["actuators"]
    names = ["time", *(f"{kind}.{joint}" for kind in ("command", "position") for joint in JOINTS)]
    rows = np.hstack([sensors["time"][:-1, None], actuators["position"], sensors["position"][:-1]])
    np.savetxt(target, rows, delimiter=",", header=",".join(names), comments="", fmt="%.9g")


def test_without_commands_the_robot_follows_the_recorded_angles(tmp_path: Path) -> None:
    body, cycles = load_body("nao-v3"), 150
    knee = 0.3 * (1.0 - np.cos(2.0 * np.pi * np.arange(cycles) * CYCLE / 1.5))
    position = np.zeros((cycles, 25))
    position[:, INDEX["LKneePitch"]] = knee
    rows = np.hstack([np.arange(cycles)[:, None] * CYCLE, position])
    names = ["time", *(f"position.{joint}" for joint in JOINTS)]
    np.savetxt(tmp_path / "angles.csv", rows, delimiter=",", header=",".join(names), comments="")
    recorded = read_signals(tmp_path / "angles.csv", body.name)
    assert not recorded.commanded
    settings = run_config(None, robot=body.name, engine="mujoco", start="hang", wear="nominal", seed=5)
    result, replayed = compare_recording(recorded, "angles.csv", settings)
    error = replayed.position[:, INDEX["LKneePitch"]] - knee
    # its RMS speed is 0.89 rad/s: angles as commands of the same cycle would be 40 ms late, 2 degrees, and more
    assert measures.rms(error) < math.radians(1.5)
    assert result.joints == () and any("follows the recorded angles" in note for note in result.notes)


def compared(capsys: pytest.CaptureFixture[str], file: Path, *options: str) -> dict:
    out = file.parent / f"compared-{file.stem}"
    given = ["--engine", "mujoco", "--seed", "3", "--out", str(out), "--overwrite", "--json", *options]
    assert run(["compare", str(file), *given]) == 0
    assert (out / "report.html").exists() and (out / "summary.json").exists()
    return json.loads(capsys.readouterr().out)


def test_the_same_robot_is_at_the_noise_floor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nominal = load_wear("nominal", load_body("nao-v3")).servo.backlash.KneePitch
    result = compared(capsys, knee_recording(tmp_path, nominal))
    assert result["first"] == "" and all(joint["excess"] == 0.0 for joint in result["joints"])
    assert result["config"]["wear"] == "nominal" and result["config"]["seed"] == 3
    gyroscope = next(s for s in result["sensors"] if s["sensor"] == "gyroscope.x")
    # the torso hangs on a hook: the gyroscope reads its noise, 0.00197 rad/s of the profile
    assert gyroscope["recorded_rms"] == pytest.approx(gyroscope["replayed_rms"], rel=0.4)


def test_the_joint_with_another_backlash_is_the_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = knee_recording(tmp_path, math.radians(3.0))
    assert compared(capsys, file)["first"] == "LKneePitch"
    as_csv(file, tmp_path / "knee.csv")
    from_csv = compared(capsys, tmp_path / "knee.csv", "--robot", "nao-v3", "--start", "hang")
    assert from_csv["first"] == "LKneePitch"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"{HEAD}\n0,0,0\n0.01,x,0\n", "line 3, column command.LKneePitch: `x`"),
        (f"{HEAD}\n0,0,0\n0.01,0\n", "line 3: has 2 cells"),
        (f"{HEAD}\n0.01,0,0\n0,0,0\n", "line 3, column time"),
        ("time,command.LKnePitch\n", "line 1, column 2: unknown column `command.LKnePitch` (did you mean"),
        ("time,command.LKneePitch\n0,0\n", "no column `position.LKneePitch`"),
        ("", "no column `time`"),
    ],
)  # fmt: skip
def test_a_malformed_csv_is_told_by_line_and_column(
    text: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bad.csv"
    file.write_text(text)
    assert run(["compare", str(file), "--robot", "nao-v3"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1 and words in said[0]


@pytest.mark.parametrize("name", ["none.csv", "none.log"])
def test_a_file_that_is_not_there_is_told_before_a_missing_body(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["compare", str(tmp_path / name)]) == 2
    assert "cannot be read (No such file or directory)" in capsys.readouterr().err
