"""ALMotion's joint methods in robot time, against the vendor's description of each."""

from __future__ import annotations

from concurrent.futures import Future
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import pytest

from bridge.adapters.naoqi.core.joint_motion import smooth
from bridge.body.joints import INDEX, JOINTS
from bridge.body.postures import POSTURES
from tests.bridge.adapters.naoqi.served import Robot
from tests.frames import standing_frame

H25 = [
    *("HeadYaw", "HeadPitch"),
    *("LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand"),
    *("LHipYawPitch", "LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch", "LAnkleRoll"),
    *("RHipYawPitch", "RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch", "RAnkleRoll"),
    *("RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RWristYaw", "RHand"),
]
"""Order of `Body` (vendor's body-parts page)."""


def test_body_has_the_vendors_names_and_order(robot: Robot) -> None:
    assert robot.motion("getBodyNames", "Body") == H25
    h21 = Robot(body="nao-v3")
    assert h21.motion("getBodyNames", "Body") == [j for j in H25 if "Hand" not in j and "Wrist" not in j]
    assert robot.motion("getBodyNames", "Head") == ["HeadYaw", "HeadPitch"]


@pytest.mark.parametrize("ahead", [-20, 0, 10, 30])
def test_a_dcm_command_is_carried_out_in_the_cycle_of_its_time(robot: Robot, ahead: int) -> None:
    """As by the emulated robot's own DCM: what is due by a frame's time is in force from that frame on."""
    head = "Device/SubDeviceList/HeadYaw/Position/Actuator/Value"
    robot.run(0.05)
    now = robot.call("DCM", "getTime", 0)
    assert now == round(1000.0 * robot.frame.time)
    before = robot.services.joints.answer()
    robot.call("DCM", "set", [head, "ClearAll", [[0.2, now + ahead]]])
    assert robot.commanded == 1  # the frame was answered already, and is to be answered anew
    answer = robot.services.joints.answer()
    assert answer.reply_to == before.reply_to
    sent = [answer.position[INDEX["HeadYaw"]], *(p[INDEX["HeadYaw"]] for p in robot.run(0.05))]
    due = max(0, ahead // 10)
    assert sent[due:] == pytest.approx([0.2] * len(sent[due:]), abs=1e-3)
    assert all(a < b for a, b in pairwise(sent[: due + 1]))


def test_an_angle_in_degrees_is_warned_of_once(robot: Robot, caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(2):
        robot.motion("angleInterpolation", "HeadYaw", 90.0, 0.3, True)
        robot.run(0.5)
    said = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert len(said) == 1
    assert "HeadYaw is 90 rad" in said[0] and "degrees?" in said[0]


def test_set_angles_goes_at_its_fraction_of_the_joints_largest_speed(robot: Robot) -> None:

    top = robot.motion("getLimits", "HeadYaw")[0][2]
    robot.motion("setAngles", "HeadYaw", 1.0, 0.1)
    way = [position[INDEX["HeadYaw"]] for position in robot.run(2.0)]
    steps = [b - a for a, b in pairwise(way)]
    assert max(steps) == pytest.approx(0.01 * 0.1 * top, rel=0.02)
    assert way[-1] == pytest.approx(1.0, abs=1e-3)


def test_largest_speeds_are_the_vendors() -> None:
    """V3.3 motors and gears, joint side (vendor's motor page): 473.72, 238.45 and 366.83 deg/s."""
    robot = Robot(body="nao-v3.3")
    for joint, speed in (("HeadYaw", 8.268), ("LHipRoll", 4.162), ("LKneePitch", 6.402)):
        assert robot.motion("getLimits", joint)[0][2] == pytest.approx(speed, rel=5e-3)


def test_an_interpolation_passes_each_angle_at_its_time_and_waits_for_the_end(robot: Robot) -> None:
    done: Future[Any] = robot.motion(
        "angleInterpolation", ["HeadYaw", "HeadPitch"], [[0.5, -0.2], 0.3], [[0.5, 1.0], 0.7], True
    )
    way = robot.run(0.99)
    assert not done.done()
    assert way[49][INDEX["HeadYaw"]] == pytest.approx(0.5, abs=2e-3)
    assert way[69][INDEX["HeadPitch"]] == pytest.approx(0.3, abs=2e-3)
    robot.run(0.03)
    assert done.done()
    assert robot.angle("HeadYaw") == pytest.approx(-0.2, abs=1e-3)


def test_a_smooth_way_rests_at_both_ends_and_never_overshoots() -> None:
    points = smooth(0.0, [1.0, 0.5, 0.5, 2.0], [0.5, 1.0, 1.5, 3.0])
    values = [value for _, value in points]
    assert all(abs(t - 0.02 * (i + 1)) < 1e-9 for i, (t, _) in enumerate(points))
    assert max(values[:25]) <= 1.0 + 1e-12
    assert all(0.5 - 1e-12 <= value <= 1.0 + 1e-12 for value in values[25:50])
    assert all(abs(value - 0.5) < 1e-12 for value in values[50:75])
    # At rest: the first and the last step are of second order in the time step.
    assert values[0] < 3.0 * (0.02 / 0.5) ** 2 + 1e-9
    assert values[-1] == 2.0
    assert values[-1] - values[-2] < 1.5 * 3.0 * (0.02 / 1.5) ** 2


def test_a_limp_joint_reads_its_sensor_and_is_held_where_it_is_when_it_stiffens(robot: Robot) -> None:
    robot.motion("setStiffnesses", "Head", 0.0)
    robot.run(0.02)
    moved = list(robot.frame.position)
    moved[INDEX["HeadYaw"]] = 0.7
    robot.frame = msgspec.structs.replace(robot.frame, position=tuple(moved), seq=robot.frame.seq + 1)
    robot.services.cycle(robot.frame)
    assert robot.motion("getAngles", "HeadYaw", False) == [0.7]
    robot.motion("setStiffnesses", "Head", 1.0)
    assert robot.run(0.05)[-1][INDEX["HeadYaw"]] == pytest.approx(0.7, abs=1e-3)


def test_resting_crouches_and_waking_stands_up(robot: Robot) -> None:
    assert robot.motion("robotIsWakeUp")
    done = robot.motion("rest")
    robot.run(4.0)
    assert done.done()
    assert robot.call("ALRobotPosture", "getPosture") == "Crouch"
    assert not robot.motion("robotIsWakeUp")
    assert robot.motion("getStiffnesses", "Head") == [0.0, 0.0]
    done = robot.motion("wakeUp")
    robot.run(4.0)
    assert done.done()
    assert robot.motion("robotIsWakeUp")
    assert robot.call("ALRobotPosture", "getPosture") == "StandInit"


@pytest.mark.parametrize("posture", sorted(POSTURES))
def test_a_posture_is_reached_joint_by_joint(robot: Robot, posture: str) -> None:
    pitch = {"LyingBelly": 1.5, "LyingBack": -1.5}.get(posture, 0.0)
    robot.run(0.5, angle=(0.0, pitch))
    done = robot.call("ALRobotPosture", "applyPosture", posture, 1.0)
    robot.run(6.0, angle=(0.0, pitch))
    assert done.result(0) is True
    for joint in JOINTS:
        assert robot.angle(joint) == pytest.approx(POSTURES[posture][INDEX[joint]], abs=5e-3), joint


def test_lying_down_is_no_fall_and_its_result_is_where_the_torso_is() -> None:
    robot = Robot(body="nao-v6")
    done = robot.call("ALRobotPosture", "goToPosture", "LyingBelly", 0.8)
    robot.run(1.0, angle=(0.0, 1.4))  # face down
    assert min(robot.motion("getStiffnesses", "Body")) > 0.99  # a fall would leave 0.1
    assert robot.wait(done, 20.0) is True
    robot = Robot(body="nao-v6")
    done = robot.call("ALRobotPosture", "goToPosture", "LyingBelly", 0.8)
    assert robot.wait(done, 20.0) is False  # the joints went there, the torso stayed upright


def test_stopping_ends_motions_and_the_calls_that_wait_for_them(robot: Robot) -> None:
    done = robot.motion("angleInterpolation", "HeadYaw", 1.0, 2.0, True)
    robot.run(1.0)
    robot.motion("killAll")
    robot.run(0.5)
    assert done.done()
    assert robot.angle("HeadYaw") == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("enabled", [True, False])
def test_the_fall_manager_ends_motions_and_lets_the_joints_go(enabled: bool) -> None:
    robot = Robot()
    if not enabled:
        robot.services.call("ALMotion", "setFallManagerEnabled", [False])
    robot.services.call("ALMotion", "setStiffnesses", ["Body", 1.0])
    motion = robot.services.call("ALMotion", "angleInterpolation", ["HeadYaw", 1.0, 2.0, True])
    robot.run(0.5)
    robot.run(0.5, angle=(0.0, 1.2))
    stiffness = robot.services.call("ALMotion", "getStiffnesses", ["Body"])
    assert motion.done() is enabled
    assert max(stiffness) == pytest.approx(0.1 if enabled else 1.0, abs=1e-4)
    assert robot.services.call("ALMotion", "getFallManagerEnabled", []) is enabled


def test_tasks_are_listed_and_killed_by_what_they_use() -> None:
    """`[name, number, joints]` of each, as the vendor's page on tasks has it."""
    services = Robot().services
    services.call("ALMotion", "setStiffnesses", ["Body", 1.0])
    head = services.call("ALMotion", "angleInterpolation", ["HeadYaw", 0.5, 2.0, True])
    arm = services.call(
        "ALMotion", "angleInterpolation", [["LElbowYaw", "LElbowRoll"], [-1.0, -0.5], 2.0, True]
    )
    listed = services.call("ALMotion", "getTaskList", [])
    assert [(name, joints) for name, _, joints in listed] == [
        ("angleInterpolation", ["HeadYaw"]),
        ("angleInterpolation", ["LElbowYaw", "LElbowRoll"]),
    ]
    assert services.call("ALMotion", "areResourcesAvailable", [["RArm"]]) is True
    assert services.call("ALMotion", "areResourcesAvailable", [["LArm"]]) is False
    services.call("ALMotion", "killTasksUsingResources", [["LElbowRoll"]])
    assert arm.done() and not head.done()
    assert services.call("ALMotion", "killTask", [listed[0][1]]) is True
    assert head.done() and services.call("ALMotion", "getTaskList", []) == []


@pytest.mark.parametrize(("pitch", "reached"), [(0.0, True), (-1.5, False)])
def test_a_posture_is_reached_only_by_a_robot_that_is_the_right_way_up(pitch: float, reached: bool) -> None:
    """And its joints are switched on for it."""
    robot = Robot(standing_frame(position=POSTURES["Crouch"], stiffness=(0.0,) * 25))
    robot.run(0.5, angle=(0.0, pitch))
    motion = robot.services.call("ALRobotPosture", "applyPosture", ["StandInit", 1.0])
    robot.run(6.0, angle=(0.0, pitch))
    assert motion.result(0.0) is reached
    assert min(robot.services.call("ALMotion", "getStiffnesses", ["Body"])) > 0.99


def test_the_keys_that_programs_read_most_have_a_value_before_their_first_event() -> None:
    """Keys and events that 40 public programs use, and those of the vendor's pages beside them."""
    keys = (Path(__file__).parent / "data" / "event_keys.txt").read_text().split()
    values = Robot().services.call("ALMemory", "getListData", [keys])
    assert [key for key, value in zip(keys, values, strict=True) if value is None] == []


def test_waking_up_and_falling_are_events() -> None:
    robot = Robot()
    robot.wait(robot.motion("wakeUp"))
    robot.run(1.0, angle=(0.0, 1.2))
    told = [name for name, value in robot.events if name.startswith("ALMotion/") and value is True]
    assert told == [
        "ALMotion/Stiffness/wakeUpStarted",
        "ALMotion/Stiffness/wakeUpFinished",
        "ALMotion/RobotIsFalling",
    ]


def test_an_interpolation_waits_for_an_earlier_one_of_its_joint() -> None:
    """The vendor's page on motion tasks, and its sample that kills the first one: the second begins then."""
    robot = Robot()
    robot.motion("setStiffnesses", "Head", 1.0)
    first = robot.motion("angleInterpolation", "HeadYaw", 0.4, 2.0, True)
    second = robot.motion("angleInterpolation", ["HeadYaw", "HeadPitch"], [[-0.4], [0.2]], [[1.0], [1.0]], True)
    robot.run(1.99)
    assert not first.done()
    assert robot.angle("HeadYaw") == pytest.approx(0.4, abs=0.01)
    assert robot.angle("HeadPitch") == pytest.approx(0.0, abs=1e-3)
    robot.run(0.1)
    assert first.done() and not second.done()
    robot.run(1.0)
    assert second.result(0.0) is None
    assert robot.angle("HeadYaw") == pytest.approx(-0.4, abs=1e-3)
    robot.motion("angleInterpolation", "HeadYaw", 0.4, 2.0, True)
    third = robot.motion("angleInterpolation", "HeadYaw", 0.1, 1.0, False)  # from where it begins
    ((_, number, _), _) = robot.motion("getTaskList")
    robot.run(1.0)
    robot.motion("killTask", number)
    there = robot.angle("HeadYaw")
    robot.wait(third, 1.1)
    assert robot.angle("HeadYaw") == pytest.approx(there + 0.1, abs=0.01)


def test_angles_that_are_set_do_not_wait() -> None:
    """The vendor's page: setAngles takes no resource, and the last command counts."""
    robot = Robot()
    robot.motion("setStiffnesses", "Head", 1.0)
    robot.motion("angleInterpolation", "HeadYaw", 0.4, 2.0, True)
    robot.motion("setAngles", "HeadYaw", -0.4, 1.0)
    robot.run(0.5)
    assert robot.angle("HeadYaw") == pytest.approx(-0.4, abs=1e-3)
