"""ALMemory's sensors against the vendor's list of keys, its units, and the signs that teams found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from bridge.adapters.naoqi.core.joints import Joints, actuator
from bridge.adapters.naoqi.core.memory import Memory
from bridge.adapters.naoqi.core.robot_facts import RobotConfig
from bridge.adapters.naoqi.core.sensor_keys import OLD_GYROSCOPE_KEYS
from bridge.adapters.naoqi.real_robot import FrameReader
from bridge.body import load_body
from bridge.body.joints import INDEX, N_JOINTS
from bridge.body.joints import JOINTS as JOINT_NAMES
from bridge.messages import SensorFrame
from tests.bridge.adapters.naoqi.served import Robot
from tests.frames import standing_frame

PREFIX = "Device/SubDeviceList/"
KEYS = (Path(__file__).parent / "data" / "almemory_keys.txt").read_text().split()


Frames = Callable[..., SensorFrame]
MemoryOf = Callable[..., Memory]


@pytest.fixture
def memory_of() -> MemoryOf:
    def make(body: str, **changes: object) -> Memory:
        sheet = load_body(body)
        joints = Joints(sheet, standing_frame())
        memory = Memory(sheet, lambda: joints.dcm, RobotConfig(sheet, "nao").keys())
        memory.update(standing_frame(**changes))
        return memory

    return make


def test_every_published_key_has_a_value(memory_of: MemoryOf) -> None:
    both = memory_of("nao-v5"), memory_of("nao-v4")
    assert len(KEYS) > 310
    assert [key for key in KEYS if all(memory.get_list([key]) == [None] for memory in both)] == []


def test_forces_are_kilograms_and_sum_to_the_total_weight(memory_of: MemoryOf) -> None:
    memory = memory_of("nao-v5", fsr=(9.81, 0.0, 0.0, 0.0, 9.81, 9.81, 9.81, 9.81))
    assert memory.get(f"{PREFIX}LFoot/FSR/FrontLeft/Sensor/Value") == pytest.approx(1.0)
    assert memory.get(f"{PREFIX}RFoot/FSR/TotalWeight/Sensor/Value") == pytest.approx(4.0)
    # All weight on one cell: the centre of pressure is at its place (vendor's page: 0.07025, 0.0299).
    assert memory.get(f"{PREFIX}LFoot/FSR/CenterOfPressure/X/Sensor/Value") == pytest.approx(0.07025)
    assert memory.get(f"{PREFIX}LFoot/FSR/CenterOfPressure/Y/Sensor/Value") == pytest.approx(0.0299)


def test_the_inertial_signs_are_those_that_were_found_on_a_v5(memory_of: MemoryOf) -> None:
    """B-Human 2015 to 2018: upright z = -9.81; x of gravity, y of specific force; gyroscope z negated."""
    memory = memory_of("nao-v5", accelerometer=(1.0, 2.0, 9.81), gyroscope=(0.1, 0.2, 0.3))
    keys = [f"{PREFIX}InertialSensor/Accelerometer{axis}/Sensor/Value" for axis in "XYZ"]
    assert memory.get_list(keys) == [-1.0, 2.0, -9.81]
    keys = [f"{PREFIX}InertialSensor/Gyroscope{axis}/Sensor/Value" for axis in "XYZ"]
    assert memory.get_list(keys) == [0.1, 0.2, -0.3]


def test_a_v4_shows_its_gyroscope_under_the_old_names_too(memory_of: MemoryOf) -> None:
    """B-Human 2013: raw counts of 12/1600 rad/s."""
    memory = memory_of("nao-v4", gyroscope=(0.75, -0.15, 0.0))
    assert memory.get_list([PREFIX + key for key in OLD_GYROSCOPE_KEYS]) == pytest.approx([100.0, -20.0])


@pytest.mark.parametrize(("body", "old"), [("nao-v5", False), ("nao-v3", False), ("nao-v4", True)])
def test_what_is_written_out_reads_back_as_the_same_frame(body: str, old: bool) -> None:
    sheet = load_body(body)
    present = [
        j not in ("LWristYaw", "RWristYaw", "LHand", "RHand") or sheet.model == "H25" for j in JOINT_NAMES
    ]
    position = tuple(0.01 * i * there for i, there in enumerate(present))
    frame = standing_frame(
        position=position,
        stiffness=tuple(1.0 * there for there in present),
        current=tuple(0.1 * there for there in present),
        temperature=tuple(38.0 * there for there in present),
        accelerometer=(0.5, -0.4, 9.7),
        gyroscope=(0.01, -0.02, 0.03 if sheet.inertial_unit.gyroscope_axes == 3 else 0.0),
        angle=(0.02, -0.03),
        fsr=tuple(range(8)),
    )
    joints = Joints(sheet, frame)
    memory = Memory(sheet, lambda: joints.dcm, {})
    memory.update(frame)
    reader = FrameReader(sheet, old)
    fields = reader.fields(memory.get_list(reader.keys))
    for name, value in fields.items():
        assert value == pytest.approx(getattr(frame, name), abs=1e-4), name


def test_velocities_are_differences_of_angles() -> None:
    robot = Robot(body="nao-v6")
    robot.call("ALMotion", "setAngles", "HeadYaw", 1.0, 0.2)
    before, *_, last = (positions[INDEX["HeadYaw"]] for positions in robot.run(0.3)[-2:])
    robot.run(0.01)
    measured = robot.call("ALMemory", "getData", "Motion/Velocity/Sensor/HeadYaw")
    assert measured == pytest.approx((last - before) / 0.01)
    assert measured > 0.5
    assert robot.call("ALMemory", "getData", "Motion/Position/Sensor/HeadYaw") == pytest.approx(last)


def test_a_stalled_motor_has_its_stall_torque() -> None:
    """Current at standstill is full voltage over resistance; torque constant times it is the stall torque."""
    body = load_body("nao-v6")
    sheet = body.joints["LKneePitch"]
    motor = body.motors[sheet.motor]
    no_load = motor.no_load_speed_rpm * 2.0 * 3.141592653589793 / 60.0
    ampere = motor.stall_torque * no_load / 21.6
    position = list(standing_frame().position)
    position[INDEX["LKneePitch"]] -= 0.1
    robot = Robot(body="nao-v6")
    current = (ampere,) * N_JOINTS
    robot.services.cycle(standing_frame(1, current=current, position=tuple(position)))
    torque = robot.call("ALMemory", "getData", "Motion/Torque/Sensor/LKneePitch")
    assert torque == pytest.approx(motor.stall_torque * sheet.gear_ratio)
    assert actuator("RHipYawPitch").startswith("LHipYawPitch")
