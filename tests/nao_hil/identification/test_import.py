"""Recordings of others: logs of B-Human, MCAP of HULKs, uneven CSV, other clocks, sensors alone.

All files are put together here, from the formats' sources.
"""

from __future__ import annotations

import gzip
import math
import struct
from pathlib import Path

import msgpack
import numpy as np
import pytest
from mcap.writer import Writer

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.errors import ConfigurationError
from emulator.wear import load_wear
from nao_hil.identification.bhuman_log import read_bhuman
from nao_hil.identification.clock import clock_offset
from nao_hil.identification.csv_file import read_csv
from nao_hil.identification.hulks_mcap import is_hulks
from nao_hil.identification.readings import LoggedRun, on_grid, timing_notes
from nao_hil.identification.recorded import encoder_grid, read_signals
from nao_hil.identification.sensors_only import at_rest, compare_fused_angle
from nao_hil.runs.run import Table
from tests.nao_hil.identification import bhuman_logs
from tests.nao_hil.identification.bhuman_logs import frame, write_log

G = 9.81
KNEE = INDEX["LKneePitch"]
STEP = 2.0 * math.pi / 4096.0
V5, V6 = load_body("nao-v5"), load_body("nao-v6")


# B-Human


def motion_frame(number: int, *, old: bool = False) -> bytes:
    """Frame of 12 ms: every joint at 0.01 times its place in B-Human's order, asked for 0.1 rad more.

    The head is off, the left hand keeps its angle, and the left knee has a stiffness of 80 %.
    """
    time = struct.pack("<I", 5000 + 12 * number)
    angles = [0.01 * place + 0.001 * number for place in range(26)]
    asked = [10000.0, 10000.0, *(angle + 0.1 for angle in angles[2:])]
    asked[bhuman_logs.JOINTS.index("lHand")] = 20000.0
    stiffness = [100] * 26
    stiffness[bhuman_logs.JOINTS.index("lKneePitch")] = 80
    stiffness[bhuman_logs.JOINTS.index("rKneePitch")] = -1
    request = struct.pack("<26f", *asked) + time + struct.pack("<26i", *stiffness)
    joints = struct.pack("<26f", *angles) + time
    if old:
        frame_info = time + struct.pack("<f", 0.012)
        return frame({"idFrameInfo": frame_info, "idJointSensorData": joints, "idJointRequest": request}, "m")
    joints += struct.pack("<26h26B26B", *range(26), *range(26), *[0] * 26)
    inertial = struct.pack("<9f", 0.1, 0.2, 0.3, 0.5, 0.0, G, 0.01, 0.02, 0.0)
    forces = struct.pack("<8f2f", *(0.1 * cell for cell in range(8)), 0.6, 2.2)
    messages = {"idFrameInfo": time, "idJointSensorData": joints, "idJointRequest": request}
    return frame({**messages, "idInertialSensorData": inertial, "idFsrSensorData": forces})


def cognition_frame(number: int) -> bytes:
    return frame({"idFrameInfo": struct.pack("<I", 7000 + 33 * number), "idCameraImage": bytes(500)}, "Upper")


def test_a_bhuman_log_is_read_by_its_own_specification(tmp_path: Path) -> None:
    frames = [each for k in range(5) for each in (motion_frame(k), cognition_frame(k))]
    readings = read_bhuman(write_log(tmp_path / "robot.log", frames))
    assert readings["sensors"]["time"] == pytest.approx(5.0 + 0.012 * np.arange(5)) and not readings.own_clock
    place = bhuman_logs.JOINTS.index("lKneePitch")
    assert readings["sensors"]["position"][:, KNEE] == pytest.approx(0.01 * place + 0.001 * np.arange(5))
    hip = bhuman_logs.JOINTS.index("lHipYawPitch")  # the right one is no motor of its own
    assert readings["sensors"]["position"][0, INDEX["LHipYawPitch"]] == pytest.approx(0.01 * hip)
    assert readings["actuators"]["position"][:, KNEE] == pytest.approx(
        0.01 * place + 0.001 * np.arange(5) + 0.1
    )
    assert np.isnan(readings["actuators"]["position"][:, [INDEX["HeadYaw"], INDEX["LHand"]]]).all()
    stiffness = readings["actuators"]["stiffness"][0]
    assert stiffness[KNEE] == pytest.approx(0.8) and stiffness[INDEX["HeadYaw"]] == 0.0
    assert np.isnan(stiffness[INDEX["RKneePitch"]])
    assert readings["sensors"]["gyroscope"][0] == pytest.approx([0.1, 0.2, 0.3])
    assert readings["sensors"]["accelerometer"][0] == pytest.approx([0.5, 0.0, G])
    assert readings["sensors"]["angle"][0] == pytest.approx([0.01, 0.02])
    # kg, in the order front left, front right, rear left, rear right
    assert readings["sensors"]["fsr"][0] == pytest.approx(0.1 * G * np.arange(8), rel=1e-3)


def test_a_bhuman_log_that_was_cut_off_has_its_whole_frames(tmp_path: Path) -> None:
    log = write_log(tmp_path / "cut.log", [motion_frame(k) for k in range(5)], closed=False)
    assert read_bhuman(log)["sensors"].rows == 4


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"\x00" + bytes(40), "is no B-Human log that specifies its types"),
        (b"\x02\x01" + bhuman_logs.text("idImage") + b"\x00" + bytes(8), "since 2014"),
        (b"\x04" + struct.pack("<I", 9), "settings have version 9"),
        (b"\x02\x05abc", "is damaged"),
        (b"", "is damaged"),
    ],
)
def test_a_file_that_is_no_such_log_is_refused(data: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / "bad.log").write_bytes(data)
    with pytest.raises(ConfigurationError, match=words):
        read_bhuman(tmp_path / "bad.log")


# HULKs


def limbs(knee: float) -> dict[str, dict[str, float]]:
    arm = dict.fromkeys(
        ("shoulder_pitch", "shoulder_roll", "elbow_yaw", "elbow_roll", "wrist_yaw", "hand"), 0.2
    )
    leg = dict.fromkeys(("hip_yaw_pitch", "hip_roll", "hip_pitch", "ankle_pitch", "ankle_roll"), 0.3)
    return {
        "head": {"yaw": 0.05, "pitch": -0.1},
        **{"left_arm": arm, "right_arm": arm},
        "left_leg": leg | {"knee_pitch": knee},
        "right_leg": leg | {"knee_pitch": -1.0, "hip_yaw_pitch": 9.0},
    }


def sensor_data(knee: float) -> dict[str, object]:
    foot = {"front_left": 0.1, "front_right": 0.2, "rear_left": 0.3, "rear_right": 0.4}
    return {
        "positions": limbs(knee),
        "inertial_measurement_unit": {
            "linear_acceleration": [0.0, 0.0, -G],
            "angular_velocity": [0.1, 0.2, 0.3],
            "roll_pitch": [0.01, 0.02],
        },
        "force_sensitive_resistors": {"left": foot, "right": foot},
    }


def hulks_file(path: Path, *, commands_at: float = 0.0, named: bool = True, rows: int = 200) -> Path:
    """Cycles of 12 ms in which the left knee bends as asked, three cycles late."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels = [
            writer.register_channel(topic, "MessagePack", 0)
            for topic in (
                "Control.main_outputs.sensor_data",
                "Control.additional_outputs.actuated_motor_commands",
                "Control.main_outputs.motor_commands",
            )
        ]
        knee = [0.3 * math.sin(0.05 * k) ** 3 for k in range(rows)]
        for k in range(rows):
            sensors = sensor_data(knee[max(k - 3, 0)])
            request = {"positions": limbs(knee[k]), "stiffnesses": limbs(0.7)}
            values = (
                sensors if named else [1, 2],
                request,
                {"positions": limbs(5.0), "stiffnesses": limbs(5.0)},
            )
            for channel, value, shift in zip(channels, values, (0.0, commands_at, 0.0), strict=True):
                time = round(1e9 * (1000.0 + 0.012 * k + shift))
                writer.add_message(channel, time, msgpack.packb(value), time)
        writer.add_message(channels[1], time + 1, msgpack.packb(None), time + 1)  # not subscribed in this cycle
        writer.finish()
    return path


def test_a_hulks_file_is_read(tmp_path: Path) -> None:
    path = hulks_file(tmp_path / "outputs.mcap")
    assert is_hulks(path)
    recorded = read_signals(path, "nao-v6")
    signals = recorded.signals
    assert len(signals.time) == 200 and signals.cycle == pytest.approx(0.012)
    row = 50
    assert signals.command[row, KNEE] == pytest.approx(0.3 * math.sin(0.05 * row) ** 3)
    assert signals.position[row, KNEE] == pytest.approx(0.3 * math.sin(0.05 * (row - 3)) ** 3)
    assert signals.stiffness[row, KNEE] == pytest.approx(0.7)
    names = ("HeadYaw", "RKneePitch", "LHipYawPitch", "RWristYaw", "LHand")
    assert signals.position[row, [INDEX[name] for name in names]] == pytest.approx([0.05, -1.0, 0.3, 0.2, 0.2])
    assert signals.accelerometer[row] == pytest.approx([0.0, 0.0, G])
    assert any("negated" in note for note in recorded.notes)
    assert signals.gyroscope[row] == pytest.approx([0.1, 0.2, 0.3])
    assert signals.fsr[row] == pytest.approx(G * np.tile([0.1, 0.2, 0.3, 0.4], 2), rel=1e-3)


def test_a_hulks_file_without_names_or_sensors_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="a message lacks a field's name"):
        read_signals(hulks_file(tmp_path / "unnamed.mcap", named=False), "nao-v6")
    with pytest.raises(ConfigurationError, match="has no topic `Control"):
        read_signals(hulks_file(tmp_path / "short.mcap", rows=1), "nao-v6")
    with pytest.raises(ConfigurationError, match="name it with --robot"):
        read_signals(hulks_file(tmp_path / "outputs.mcap"), None)


# CSV


def test_a_csv_with_names_of_its_own_is_mapped(tmp_path: Path) -> None:
    with gzip.open(tmp_path / "robot.csv.gz", "wt") as file:
        file.write("t,LKneePitch_rad,HeadYaw_rad,acc_z_g,battery\n10.0,0.1,0.2,-1.0,8\n10.1,0.2,,-1.1,7\n")
    mapping = tmp_path / "columns.toml"
    mapping.write_text(
        '[columns]\ntime = "t"\n"position.*" = "*_rad"\n'
        '"accelerometer.z" = { column = "acc_z_g", scale = -9.81 }\n'
    )
    readings = read_csv(tmp_path / "robot.csv.gz", mapping)
    assert readings["sensors"]["time"].tolist() == [10.0, 10.1] and not readings["actuators"].rows
    assert readings["sensors"]["position"][:, KNEE].tolist() == [0.1, 0.2]
    assert readings["sensors"]["position"][0, INDEX["HeadYaw"]] == 0.2
    assert math.isnan(readings["sensors"]["position"][1, INDEX["HeadYaw"]])
    assert readings["sensors"]["accelerometer"][:, 2] == pytest.approx([9.81, 1.1 * 9.81])


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        ('[columns]\n"position.LKnePitch" = "a"', "unknown name `position.LKnePitch` .did you mean"),
        ('[columns]\ntime = "tme"', "time: the file has no column `tme` .did you mean `time`"),
        ('[columns]\ntime = { colum = "time" }', "unknown key"),
        ('[columns]\n"position.*" = "*"', "no column `time`"),
    ],
)
def test_a_wrong_mapping_is_told(mapping: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "robot.csv").write_text("time,LKneePitch\n0,0\n1,0\n")
    (tmp_path / "columns.toml").write_text(mapping)
    with pytest.raises(ConfigurationError, match=words):
        read_csv(tmp_path / "robot.csv", tmp_path / "columns.toml")


def test_uneven_samples_keep_their_noise_and_only_they_count() -> None:
    random = np.random.default_rng(3)
    time = np.cumsum(random.uniform(0.03, 0.046, 2000))
    noise = random.normal(0.0, 0.05, (2000, 3))
    angles = np.zeros((2000, 25))
    angles[:, KNEE] = np.sin(time - time[0])
    readings = LoggedRun(time, {"accelerometer": noise, "position": angles}, time, {})
    signals = on_grid(readings, 0.01)
    rows = signals.measured
    assert rows.sum() == 2000
    # at the rows that count the sensor has its noise whole; interpolated it would be 0.82 of it
    assert signals.accelerometer[rows].std() == pytest.approx(noise.std(), rel=1e-9)
    assert signals.accelerometer[~rows].std() < 0.9 * noise.std()
    # the angle belongs to the row's time, not to that of the sample up to half a cycle away
    assert np.abs(signals.position[:, KNEE] - np.sin(signals.time)).max() < 4e-4
    (note,) = timing_notes(time, 0.01)
    assert "2000 samples, 38 ms apart in the median" in note


@pytest.mark.parametrize("signal", ["command", "position"])
def test_angles_in_degrees_are_asked_about_and_a_scale_mends_them(signal: str, tmp_path: Path) -> None:
    other = "position" if signal == "command" else "command"
    (tmp_path / "degrees.csv").write_text(
        f"time,{signal}.LKneePitch,{other}.LKneePitch\n0.00,90,0.5\n0.01,45,0.6\n"
    )
    with pytest.raises(ConfigurationError, match=r"LKneePitch.*degrees"):
        read_csv(tmp_path / "degrees.csv")
    (tmp_path / "columns.toml").write_text(
        f'[columns]\ntime = "time"\n"position.*" = "{other}.*"\n'
        f'"command.*" = {{ column = "{signal}.*", scale = 0.017453292519943295 }}\n'
    )
    commands = read_csv(tmp_path / "degrees.csv", tmp_path / "columns.toml")["actuators"]["position"][:, KNEE]
    assert commands == pytest.approx([math.pi / 2, math.pi / 4])


# clocks


def followed(offset: float, *, drift: float = 0.0, lag: float = 0.040, repeat: bool = False) -> LoggedRun:
    """30 s in which a knee follows its command; the commands' clock is `offset` behind, off by `drift`."""
    random = np.random.default_rng(8)
    time = np.arange(3000) * 0.01
    if repeat:
        wave = np.sin(2.0 * np.pi * time)
    else:
        wave = np.interp(time, np.arange(0.0, 31.0, 0.5), random.uniform(-0.5, 0.5, 62))
    command, position = np.full((3000, 25), np.nan), np.zeros((3000, 25))
    command[:, KNEE] = wave
    position[:, KNEE] = np.interp(time - lag, time, wave) + random.normal(0.0, 2e-4, 3000)
    asked = (time - offset) * (1.0 + drift)
    return LoggedRun(time, {"position": position}, asked, {"command": command}, own_clock=True)


@pytest.mark.parametrize("offset", [0.0, 1.234, -8.1, 1.7e9])
def test_the_offset_of_the_commands_clock_is_found(offset: float) -> None:
    found, notes = clock_offset(followed(offset), V5, "x")
    assert found == pytest.approx(offset, abs=3e-3)
    assert "40 ms as real robots do" in notes[0] and len(notes) == 1


def test_commands_of_another_motion_are_refused() -> None:
    readings = followed(0.0)
    readings["sensors"]["position"][:, KNEE] = np.random.default_rng(1).normal(0.0, 0.1, 3000)
    with pytest.raises(ConfigurationError, match="follow them at no offset"):
        clock_offset(readings, V5, "x.csv")


# the encoders' grid


def test_angles_of_encoders_are_on_the_grid_with_its_shift() -> None:
    random = np.random.default_rng(2)
    smooth = random.uniform(-1.0, 1.0, (500, 25))
    shift = np.where(np.arange(25) % 2, 4.2e-5, -4.2e-5)
    grid = np.rint(smooth / STEP) * STEP + shift
    found = encoder_grid(V6, {"position": np.round(grid, 5)})  # as a file with five decimals has them
    assert len(found.joints) == 23  # not the hands
    for name, joint in found.joints.items():
        assert joint.on_grid and joint.shift == pytest.approx(shift[JOINTS.index(name)], abs=5e-7)
    assert "Angles of 23 of 23 joints are on the encoders' grid of 1.534e-03 rad" in found.sentence
    filtered = 0.5 * (grid[1:] + grid[:-1]) + 1e-4 * smooth[1:] + 3e-4 * smooth[:-1]
    assert not any(joint.on_grid for joint in encoder_grid(V6, {"position": filtered}).joints.values())
    assert not encoder_grid(V6, {"position": np.zeros((500, 25))}).joints


# sensors alone


def rocking(amplitude: float) -> LoggedRun:
    """A torso that pitches to and fro about its accelerometer, at uneven times, with the true angle."""
    time = np.cumsum(np.random.default_rng(4).uniform(0.03, 0.046, 1500))
    angle, rate = amplitude * np.sin(2.0 * time), 2.0 * amplitude * np.cos(2.0 * time)
    zero = np.zeros_like(time)
    return LoggedRun(
        time,
        {
            "angle": np.stack([zero, angle], axis=1),
            "accelerometer": G * np.stack([-np.sin(angle), zero, np.cos(angle)], axis=1),
            "gyroscope": np.stack([zero, rate, np.full_like(time, np.nan)], axis=1),
        },
        time,
        {},
    )


def test_the_fused_angle_of_a_consistent_recording_is_the_filters() -> None:
    readings, parameters = rocking(0.3), load_wear("nominal").sensors.fused_angle
    found = compare_fused_angle(readings["sensors"], parameters)
    assert found is not None
    assert found.recorded_rms[1] == pytest.approx(0.3 / math.sqrt(2.0), rel=0.02)
    assert max(found.difference) < math.radians(1.0)
    readings["sensors"]["angle"][:] *= 2.0
    twice = compare_fused_angle(readings["sensors"], parameters)
    assert twice is not None and twice.difference[1] == pytest.approx(0.3 / math.sqrt(2.0), rel=0.1)
    without = {name: values for name, values in readings["sensors"].items() if name != "gyroscope"}
    assert compare_fused_angle(Table(without), parameters) is None


def test_the_stretch_at_rest_is_found() -> None:
    random = np.random.default_rng(6)
    time = np.arange(1000) * 0.01
    rate = random.normal(0.01, 0.004, (1000, 3))
    moves = (time < 3.0) | (time > 8.0)
    rate[moves, 1] += 0.5 * np.sin(20.0 * time[moves])
    rest = at_rest(on_grid(LoggedRun(time, {"gyroscope": rate}, time, {}), 0.01))
    assert rest is not None
    assert time[rest][0] == pytest.approx(3.0, abs=0.1) and time[rest][-1] == pytest.approx(8.0, abs=0.1)
    rate[:, 0] += np.sin(20.0 * time)
    assert at_rest(on_grid(LoggedRun(time, {"gyroscope": rate}, time, {}), 0.01)) is None
