"""Head and arms while the walker has the robot (vendor's sample motion_walk.py moves the arms in a walk)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from bridge.errors import NaoqiRefused
from tests.bridge.adapters.naoqi.served import Robot


class Walks:
    """A walk that has the robot's joints."""

    has_robot = active = True

    def with_joints(self, work: Callable[[], Any], *, stop: bool) -> Any:
        raise NaoqiRefused("The robot walks.")


@pytest.fixture
def robot() -> Robot:
    robot = Robot()
    robot.services.give_away()
    robot.services.handover = Walks()  # type: ignore[assignment]
    return robot


def order(robot: Robot) -> dict[str, float]:
    told = robot.services.upper_body.order(walks=True)
    return dict(zip(told.joints, told.position, strict=True))


def test_the_head_goes_where_it_is_sent_during_a_walk(robot: Robot) -> None:
    before = robot.commanded
    robot.motion("setAngles", "HeadYaw", 0.4, 1.0)
    assert robot.commanded == before + 1
    robot.run(1.0)
    assert order(robot) == pytest.approx({"HeadYaw": 0.4, "HeadPitch": 0.0}, abs=1e-3)


def test_an_arm_is_the_walk_s_again_when_its_motion_is_over(robot: Robot) -> None:
    done = robot.motion("angleInterpolation", "LShoulderPitch", 0.5, 1.0, True)
    robot.run(0.5)
    assert order(robot)["LShoulderPitch"] == pytest.approx(0.5 * (0.5 + 1.4), abs=0.1)
    robot.wait(done)
    assert "LShoulderPitch" not in order(robot)


def test_the_dcm_takes_commands_of_head_arms_and_leds_during_a_walk(robot: Robot) -> None:
    def dcm(method: str, *arguments: Any) -> Any:
        return robot.call("DCM", method, *arguments)

    dcm(
        "set",
        ["Device/SubDeviceList/HeadYaw/Position/Actuator/Value", "ClearAll", [[0.4, dcm("getTime", 100)]]],
    )
    dcm("createAlias", ["Shoulders", [f"{side}ShoulderPitch/Position/Actuator/Value" for side in "LR"]])
    dcm("setAlias", ["Shoulders", "ClearAll", "time-separate", 0, [dcm("getTime", 100)], [[0.9], [0.8]]])
    robot.run(0.05)
    assert {"HeadYaw", "LShoulderPitch", "RShoulderPitch"} <= set(order(robot))
    robot.run(1.0)
    assert order(robot)["HeadYaw"] == pytest.approx(0.4, abs=1e-3)
    dcm("set", ["Face/Led/Red/Left/0Deg/Actuator/Value", "Merge", [[1.0, 0]]])
    dcm("createAlias", ["Mixed", [f"{joint}/Position/Actuator/Value" for joint in ("HeadYaw", "LKneePitch")]])
    for name in ("LKneePitch/Hardness/Actuator/Value", "Mixed"):
        with pytest.raises(NaoqiRefused, match="walks"):
            dcm("set", [name, "Merge", [[0.5, 0]]])


@pytest.mark.parametrize("names", ["LLeg", "Body", ["HeadYaw", "LKneePitch"]])
def test_the_legs_are_the_walk_s(robot: Robot, names: Any) -> None:
    with pytest.raises(NaoqiRefused, match="walks"):
        robot.motion("setAngles", names, 0.1, 0.5)


def test_a_walk_takes_stiff_legs_and_refuses_limp_ones(robot: Robot) -> None:
    """A walk ends where a leg's stiffness is 0.6 or less (vendor's page)."""
    robot.motion("setStiffnesses", "Body", 1.0)
    with pytest.raises(NaoqiRefused, match="walks"):
        robot.motion("setStiffnesses", "Body", 0.6)


def test_what_the_program_moves_is_not_held_where_it_is_measured(robot: Robot) -> None:
    robot.motion("setAngles", "HeadYaw", 0.4, 0.1)
    robot.run(0.2)
    robot.services.hold()
    robot.run(2.0)
    assert order(robot)["HeadYaw"] == pytest.approx(0.4, abs=1e-3)
