"""Files of other robots that are only evaluated: NaoTH, HumanoidRobotSoccer, a learned leg model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.errors import ConfigurationError
from nao_hil.identification.leg_model import ORDERS, compare_leg_model, load_model
from nao_hil.identification.naoth_log import read_naoth
from nao_hil.identification.readings import LoggedRun, Signals, on_grid
from nao_hil.identification.recorded import read_signals
from tests.nao_hil.identification import bhuman_logs, naoth_logs
from tests.nao_hil.identification.naoth_logs import entry, frame, integer, write_log
from tests.nao_hil.identification.onnx_files import write_network

KNEE = INDEX["LKneePitch"]


def naoth_frames(count: int, joints: int = 26) -> list[bytes]:
    """A knee that follows its request of the frame before; the others are told apart by their angles."""
    found = []
    for k in range(count):
        angles = [0.01 * number for number in range(joints)]
        requests = [0.02 * number for number in range(joints)]
        place = naoth_logs.JOINTS.index("LKneePitch")
        angles[place], requests[place] = 0.1 + 0.01 * k, 0.1 + 0.01 * (k + 1)
        found.append(
            frame(
                k,
                5000 + 12 * k,
                angles,
                requests,
                accelerometer=(1.0, 2.0, -9.5),
                gyroscope=(0.1, 0.2, 0.3),
                angle=(0.05, -0.02),
                fsr=(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8),
            )
        )
    return found


def test_a_naoth_log_is_read_by_its_published_messages(tmp_path: Path) -> None:
    recorded = read_signals(write_log(tmp_path / "sensor.log", naoth_frames(20)), "nao-v6")
    signals = recorded.signals
    assert len(signals.time) == 20 and signals.cycle == pytest.approx(0.012)
    assert signals.position[:, KNEE] == pytest.approx(0.1 + 0.01 * np.arange(20))
    assert signals.command[:, KNEE] == pytest.approx(0.11 + 0.01 * np.arange(20))
    for joint in ("HeadYaw", "LHipYawPitch", "RAnkleRoll", "LWristYaw", "RHand"):
        assert signals.position[3, INDEX[joint]] == pytest.approx(0.01 * naoth_logs.JOINTS.index(joint))
    assert signals.stiffness[3] == pytest.approx(np.full(25, 0.8))
    # as NAOqi has them (docs/real-robot.md): z of the gyroscope, x and z of the accelerometer are negated
    assert signals.accelerometer[3] == pytest.approx([-1.0, 2.0, 9.5])
    assert signals.gyroscope[3] == pytest.approx([0.1, 0.2, -0.3])
    assert signals.angle[3] == pytest.approx([0.05, -0.02])
    assert signals.fsr[3] == pytest.approx(9.81 * 0.1 * np.arange(1, 9))


def test_a_naoth_log_of_a_v3_and_one_that_was_cut_off(tmp_path: Path) -> None:
    """Logs of a V3 have 22 joints; the last frame of a log that was cut off is left out."""
    path = write_log(tmp_path / "sensor.log", naoth_frames(5, joints=22))
    whole = read_naoth(path)
    assert np.isnan(whole["sensors"]["position"][:, INDEX["LWristYaw"]]).all()
    assert np.isfinite(whole["sensors"]["position"][:, INDEX["LAnkleRoll"]]).all()
    path.write_bytes(path.read_bytes()[:-400])
    assert read_naoth(path)["sensors"].rows == 4


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (entry(1, "FrameInfo", integer(2, 5)) + entry(2, "FrameInfo", integer(2, 9)), "two are needed; it has"),
        (entry(1, "SensorJointData", b"\x0f"), "two are needed"),
        (naoth_frames(1)[0].replace(b"\x09", b"\x0f"), "is damaged, or no log of NaoTH"),
        (entry(1, "FrameInfo", b"")[:-1] + b"\xff", "is damaged"),
    ],
)
def test_a_naoth_log_that_cannot_be_read_is_told(content: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / "bad.log").write_bytes(content)
    with pytest.raises(ConfigurationError, match=words):
        read_signals(tmp_path / "bad.log", "nao-v6")


SOCCER = (
    *(name for name in bhuman_logs.JOINTS[:2]),
    "lShoulderPitchlShoulderRoll",
    *(name for name in bhuman_logs.JOINTS[4:]),
)
"""Names of the published header: 25, of 26 joints."""


def soccer_csv(path: Path, rows: int = 40) -> Path:
    """A recording of the data set: its header, its units, each value the number of its joint in hundredths."""
    head = ["", "filename", "time", *(f"{kind}_{axis}" for kind in ("gyro", "acc") for axis in "xyz")]
    head += ["angle_x", "angle_y", "upright", *(f"jointAngles_{name}" for name in SOCCER)]
    head += [f"jointRequest_{name}" for name in SOCCER]
    lines = [",".join(head)]
    for k in range(rows):
        values = [f"{0.01 * joint:.4f}" for joint in range(25)]  # the last joint has no column
        sensors = ["0.1", "0.2", "0.3", "0.0", "0.0", "-9.81", "0.01", "0.02", "True"]
        lines.append(",".join([str(k), "one.log", str(7_200_000 + 12 * k), *sensors, *values, *values]))
    path.write_text("\n".join(lines))
    return path


def test_the_columns_of_humanoid_robot_soccer_are_shifted_as_its_header_shifts_them(tmp_path: Path) -> None:
    recorded = read_signals(soccer_csv(tmp_path / "one.csv"), "nao-v6", columns=Path("humanoid-robot-soccer"))
    signals = recorded.signals
    assert signals.cycle == pytest.approx(0.012) and len(signals.time) == 40
    for name in ("HeadPitch", "LShoulderPitch", "LShoulderRoll", "LHipYawPitch", "LKneePitch", "RAnklePitch"):
        number = bhuman_logs.JOINTS.index(name[0].lower() + name[1:])
        for signal in (signals.position, signals.command):
            assert signal[5, INDEX[name]] == pytest.approx(0.01 * number), name
    assert np.isnan(signals.position[:, INDEX["RAnkleRoll"]]).all()
    assert signals.gyroscope[5] == pytest.approx([0.1, 0.2, 0.3])
    assert signals.accelerometer[5, 2] == pytest.approx(9.81)
    assert any("shows gravity" in note for note in recorded.notes)


V6 = load_body("nao-v6")
RATES = 0.05 * np.arange(1, 12)
"""Of the legs' joints in the order of the newer release, rad/s."""


def ramps(rows: int = 60, order: str = "by leg") -> Signals:
    """Each leg joint turns at a rate of its own, four frames behind its request."""
    time = 0.012 * np.arange(rows)
    angles, requests = np.zeros((rows, 25)), np.zeros((rows, 25))
    for joint, rate in zip(ORDERS[order], RATES, strict=True):
        slot = INDEX["LHipYawPitch" if joint == "RHipYawPitch" else joint]
        angles[:, slot], requests[:, slot] = rate * time, rate * (time + 0.048)
    readings = LoggedRun(time, {"position": angles}, time, {"command": requests})
    return on_grid(readings, 0.012)


def hold_and_turn(frames: int) -> tuple[np.ndarray, np.ndarray]:
    """The newest measurement, and the way of each joint in some frames."""
    weights = np.zeros((66, 11))
    weights[55:] = np.eye(11)
    return weights, 0.012 * frames * RATES


def test_a_model_is_right_at_its_horizon_and_in_its_order(tmp_path: Path) -> None:
    model = load_model(write_network(tmp_path / "model.onnx", *hold_and_turn(2)))
    for order in ORDERS:
        signals = ramps(order=order)
        found = compare_leg_model(model, "model.onnx", V6, signals, ramps(order="by leg"))
        assert found.order == order
        errors = [each.overall("recorded") for each in found.horizons]
        assert int(np.argmin(errors)) == 2 and errors[2] < 1e-6 < 1e-3 < errors[1]
        # one frame beside it each joint is off by its rate times 12 ms
        assert found.horizons[3].recorded["LHipPitch"] == pytest.approx(
            0.012 * RATES[ORDERS[order].index("LHipPitch")], rel=1e-3
        )


def test_a_file_that_is_no_leg_model_is_told(tmp_path: Path) -> None:
    weights = np.zeros((88, 11))
    with pytest.raises(ConfigurationError, match=r"takes x \[4, 22\]; the network"):
        load_model(write_network(tmp_path / "four.onnx", weights, np.zeros(11), frames=4))
    (tmp_path / "text.onnx").write_text("no network")
    with pytest.raises(ConfigurationError, match="no network that onnxruntime can load"):
        load_model(tmp_path / "text.onnx")
    with pytest.raises(ConfigurationError, match="NAO V6 with 12 ms"):
        compare_leg_model(lambda values: values[0, :11], "", load_body("nao-v5"), ramps(), ramps())
