"""Identification: the motion that shows the drives, loads of the joint model, drives recovered from a robot."""

from __future__ import annotations

import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import absent_joints, total_mass
from bridge.guard import Guard
from bridge.recording.recorder import Recorder
from emulator.poses import ORIGIN
from emulator.start import START_POSES
from emulator.wear import load_wear
from nao_hil.arguments import actuator_frame
from nao_hil.cli.main import run
from nao_hil.identification.comparison_run import HANG
from nao_hil.identification.excitation import excitation
from nao_hil.identification.servo_model import GRAVITY, joint_loads
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import run_config
from tests.frames import standing_frame

CYCLE = 0.01
TRUTH = {"delay": 0.041, "full_voltage_error": 0.09, "gear_compliance": 0.010, "dry_friction": 0.065}
TIME_CONSTANTS = {"lead": 0.003, "motor_time_constant": 0.0055, "gear_relaxation": 0.014}
"""Other than those of the base, s."""
BACKLASH = {"HeadPitch": 1.8, "KneePitch": 0.9, "ElbowYaw": 1.3}
"""deg"""


def test_loads_are_the_slope_of_the_potential_energy() -> None:
    """Checked with the engine's centre of mass: torque = -d(M g z)/dq."""
    settings = run_config(None, start="hang", seed=0, wear="ideal")
    angles = 0.3 * np.cos(np.arange(25.0))
    with build_robot(settings) as robot:
        body, engine = robot.body, robot.multibody
        names = engine.joints
        slots = [INDEX["LHipYawPitch" if name == "RHipYawPitch" else name] for name in names]
        loads = joint_loads(body, angles[None], np.zeros((1, 2)))

        def height(positions: np.ndarray) -> float:
            engine.place(ORIGIN, joints=positions.tolist())
            return float(engine.com()[2])

        for number, name in enumerate(names):
            step = np.zeros(len(names))
            step[number] = 1e-3
            slope = (height(angles[slots] + step) - height(angles[slots] - step)) / 2e-3
            torque = -total_mass(body) * GRAVITY * slope
            assert loads[name].cosine[0] == pytest.approx(torque, abs=2e-3), name


def triangle(time: np.ndarray, period: float) -> np.ndarray:
    return np.asarray(2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * time / period)))


def recording(folder: Path) -> Path:
    """A hanging robot with drives of its own: a joint of each limb goes slowly to and fro, then in steps.

    On MuJoCo: PyBullet has the rotors' inertia in the links, which the drives' values make up for.
    """
    wear = load_wear("nominal", load_body("nao-v3"))
    backlash = msgspec.structs.replace(
        wear.servo.backlash, **{name: math.radians(width) for name, width in BACKLASH.items()}
    )
    servo = msgspec.structs.replace(wear.servo, backlash=backlash, **TRUTH, **TIME_CONSTANTS)
    settings = run_config(None, engine="mujoco", start="hang", seed=21)
    file = folder / "frames.mcap"
    with (
        build_robot(settings, wear=msgspec.structs.replace(wear, servo=servo)) as robot,
        Recorder(file, settings) as recorder,
    ):
        time = np.arange(1500) * CYCLE
        commands = np.tile(robot.frame.position, (len(time), 1))
        steps = 0.04 * np.where((time * 1.7) % 1.0 < 0.5, 1.0, -1.0) * (time > 11.0)
        slow = triangle(time, 5.0) * (time < 10.0)
        bend = 0.5 - 0.5 * np.cos(np.pi * np.clip(time, 0.0, 1.0))
        for joint, middle, half in (
            ("HeadPitch", -0.05, 0.4),
            ("LElbowYaw", 0.0, 0.4),
            ("RElbowYaw", 0.0, 0.4),
            ("LKneePitch", 0.6, 0.45),
            ("RKneePitch", 0.6, 0.45),
        ):
            commands[:, INDEX[joint]] += middle * bend + half * slow + (0.0 if "Knee" in joint else steps)
        for joint in ("LHipPitch", "RHipPitch"):
            commands[:, INDEX[joint]] -= 0.6 * bend
        for row in commands:
            recorder.sensors(robot.frame, robot.truth())
            command = actuator_frame(robot.seq, row, 1.0)
            recorder.command(command)
            robot.advance(command)
        recorder.sensors(robot.frame, robot.truth())
    return file


@pytest.mark.parametrize("noise", [0.0, 0.2], ids=["exact", "noisy"])
def test_angles_that_are_the_commands_are_refused_and_give_no_backlash(
    noise: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Drives with a least lag do not fit them; their errors would be taken for a backlash of over a degree."""
    time = np.arange(4000) * 0.012
    angles = np.column_stack([0.5 * triangle(time, 8.0), 0.6 + 0.4 * triangle(time, 7.0)])
    angles[:, 0] *= time < 24.0
    angles[:, 1] = np.where(time < 24.0, 0.6, angles[:, 1])
    errors = np.random.default_rng(5).normal(0.0, math.radians(noise), angles.shape)
    rows = np.column_stack([time, angles, angles + errors])
    file = tmp_path / "ideal.csv"
    head = "time,command.HeadYaw,command.LKneePitch,position.HeadYaw,position.LKneePitch"
    np.savetxt(file, rows, delimiter=",", header=head, comments="", fmt="%.6f")
    assert run(["identify", str(file), "--robot", "nao-v6", "--out", str(tmp_path / "x.toml")]) == 2
    assert "commands" in capsys.readouterr().err
    assert not (tmp_path / "x.toml").exists()


def test_the_drives_of_a_recorded_robot_are_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = tmp_path / "mine.toml"
    assert run(["identify", str(recording(tmp_path)), "--out", str(profile), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    values = {name: each["value"] for name, each in found["parameters"].items()}
    assert values["delay"] == pytest.approx(TRUTH["delay"], abs=2e-3)
    assert values["dry_friction"] == pytest.approx(TRUTH["dry_friction"], rel=0.15)
    assert values["stiffness.KneePitch"] == pytest.approx(1.0 / (0.09 / 7.786 + 0.010), rel=0.3)
    # Lead and motor stand in for each other: of five seeds each is 0.57 to 1.63 times the truth. The lag of the
    # drive, their difference, is 0.87 to 1.22 times the truth.
    lag = values["motor_time_constant"] - values["lead"]
    assert lag == pytest.approx(TIME_CONSTANTS["motor_time_constant"] - TIME_CONSTANTS["lead"], rel=0.5)
    assert values["gear_relaxation"] == pytest.approx(TIME_CONSTANTS["gear_relaxation"], rel=0.5)
    for name in ("HeadPitch", "KneePitch", "ElbowYaw"):
        assert math.degrees(values[f"backlash.{name}"]) == pytest.approx(BACKLASH[name], abs=0.2)
    # the ankles did not move
    assert "backlash.AnklePitch" in found["assumed"] and "backlash.AnklePitch" not in values
    text = profile.read_text()
    loaded, nominal = load_wear(str(profile)), load_wear("nominal", load_body("nao-v3"))
    assert loaded.servo.delay == pytest.approx(values["delay"], rel=1e-5)
    assert loaded.servo.backlash.AnklePitch == nominal.servo.backlash.AnklePitch
    assert loaded.sensors == nominal.sensors and loaded.servo.heating == nominal.servo.heating
    assert "# identified: " in text and "AnklePitch = 0.0214  # assumed" in text


@pytest.mark.parametrize(("out", "words"), [("mine", "ends with .toml"), ("mine.toml", "cannot be read")])
def test_a_wrong_file_is_told(out: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["identify", str(tmp_path / "none.mcap"), "--out", str(tmp_path / out)]) == 2
    assert words in capsys.readouterr().err


def test_a_joint_that_nothing_moves_cannot_be_identified(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "rest.csv"
    names = [f"{kind}.{joint}" for kind in ("command", "position") for joint in JOINTS]
    body = load_body("nao-v3")
    rows = np.hstack([np.arange(100)[:, None] * body.cycle, np.zeros((100, 50))])
    np.savetxt(file, rows, delimiter=",", header=",".join(["time", *names]), comments="")
    assert run(["identify", str(file), "--robot", "nao-v3", "--out", str(tmp_path / "mine.toml")]) == 2
    assert "nao-hil excite" in capsys.readouterr().err


LEGS = [INDEX[joint] for joint in JOINTS if "Hip" in joint or "Knee" in joint or "Ankle" in joint]


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
@pytest.mark.parametrize("start", ["hang", "stand"])
def test_the_guard_lets_every_command_through(name: str, start: str) -> None:
    body = load_body(name)
    pose = START_POSES[HANG].angles if start == HANG else POSTURES["Stand"]
    commands = excitation(body, pose, 60.0, hanging=start == HANG)
    moved = np.ptp(commands, axis=0) > 0.3
    assert commands.shape == (round(60.0 / body.cycle), 25)
    assert moved[LEGS].all() if start == HANG else not np.ptp(commands[:, LEGS], axis=0).any()
    assert moved[INDEX["HeadYaw"]] and moved[INDEX["RElbowYaw"]]
    assert not moved[[INDEX[joint] for joint in absent_joints(body)]].any()
    present = [INDEX[joint] for joint in JOINTS if joint not in absent_joints(body)]
    # the hanging pose has elbows that are straighter than their range
    assert commands[-1, present] == pytest.approx(np.array(pose)[present], abs=0.035)
    guard, frame = Guard(body), standing_frame(position=pose)
    for number, position in enumerate(commands):
        wanted = actuator_frame(0, position, 1.0)
        command = guard.cycle(frame, guard.check(wanted, 0))
        assert command is not None
        changed = np.abs(np.subtract(command.position, wanted.position))[present]
        assert changed.max() < 1e-9, f"cycle {number}"


@pytest.mark.parametrize(
    ("options", "words"),
    [(("--duration", "10"), "60 s at least"), (("--start", "lie-back"), "known: hang, stand")],
)
def test_a_motion_that_there_is_not_is_refused(
    options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["excite", *options]) == 2
    assert words in capsys.readouterr().err
