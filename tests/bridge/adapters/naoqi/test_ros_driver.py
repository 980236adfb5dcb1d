"""What naoqi_driver2 asks of a NAO (its sources, 2.1): ROS drivers run unchanged."""

from __future__ import annotations

import pytest

from bridge.adapters.naoqi.core.joints import actuator
from bridge.body import load_body
from bridge.body.joints import INDEX, N_JOINTS
from tests.bridge.adapters.naoqi.served import Robot
from tests.frames import standing_frame

PARTS = ("Body/Device/LeftArm", "Body/Device/RightArm", "Body/Device/Hand/Left", "Body", "Body/Device/Legs")


def test_it_finds_versions_and_configuration() -> None:
    robot = Robot(standing_frame(), "nao-v6")
    values = robot.call("ALMemory", "getListData", [f"RobotConfig/{part}/Version" for part in PARTS])
    assert all(isinstance(value, str) for value in values)
    assert robot.call("ALRobotModel", "_getConfigMap")["RobotConfig/Head/Device/Micro/Version"] == "2"
    assert robot.call("ALRobotModel", "_getMicrophoneConfig") == 2
    assert len(robot.call("ALSystem", "systemVersion").split(".")) == 4
    assert robot.call("ALTouch", "exit") is None
    assert robot.call("ALSpeechRecognition", "_enableFreeSpeechToText") is None


def test_each_joint_has_temperature_and_stiffness_under_its_own_name() -> None:
    robot = Robot(standing_frame(), "nao-v6")
    joints = robot.call("ALMotion", "getBodyNames", "JointActuators")
    assert "RHipYawPitch" in joints
    for key in ("Temperature/Sensor/Value", "Hardness/Actuator/Value", "Position/Sensor/Value"):
        values = robot.call(
            "ALMemory", "getListData", [f"Device/SubDeviceList/{joint}/{key}" for joint in joints]
        )
        assert None not in values
        assert values[joints.index("RHipYawPitch")] == values[joints.index("LHipYawPitch")]


def test_velocities_are_differences_of_angles() -> None:
    robot = Robot(standing_frame(), "nao-v6")
    robot.call("ALMotion", "setAngles", "HeadYaw", 1.0, 0.2)
    before, *_, last = (positions[INDEX["HeadYaw"]] for positions in robot.run(0.3)[-2:])
    robot.run(0.01)
    measured = robot.call("ALMemory", "getData", "Motion/Velocity/Sensor/HeadYaw")
    assert measured == pytest.approx((last - before) / 0.01)
    assert measured > 0.5
    assert robot.call("ALMemory", "getData", "Motion/Position/Sensor/HeadYaw") == pytest.approx(last)
    with pytest.raises(Exception, match="no data"):
        robot.call("ALMemory", "getData", "Motion/Velocity/Sensor/LHand")


def test_a_stalled_motor_has_its_stall_torque() -> None:
    """Current at standstill is full voltage over resistance; torque constant times it is the stall torque."""
    body = load_body("nao-v6")
    sheet = body.joints["LKneePitch"]
    motor = body.motors[sheet.motor]
    no_load = motor.no_load_speed_rpm * 2.0 * 3.141592653589793 / 60.0
    ampere = motor.stall_torque * no_load / 21.6
    position = list(standing_frame().position)
    position[INDEX["LKneePitch"]] -= 0.1
    robot = Robot(standing_frame(), "nao-v6")
    current = (ampere,) * N_JOINTS
    robot.services.cycle(standing_frame(1, current=current, position=tuple(position)))
    torque = robot.call("ALMemory", "getData", "Motion/Torque/Sensor/LKneePitch")
    assert torque == pytest.approx(motor.stall_torque * sheet.gear_ratio)
    assert actuator("RHipYawPitch").startswith("LHipYawPitch")
