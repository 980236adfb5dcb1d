"""ALMotion's protection of the arms by the vendor's pages: an arm stops short of the body, or bumps without."""

from __future__ import annotations

import itertools
import math

import pytest

from bridge.adapters.naoqi.core.protection import ARM_MARGIN, ArmClearance
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import BodyTree
from bridge.body.postures import POSTURES
from tests.bridge.adapters.naoqi.served import Robot

INTO_HEAD = [math.radians(angle) for angle in (-50, 6, 0, -85, 0, 0)]
"""The pose of the vendor's sample in which the left arm is at the head, within the elbow's range."""
ARM = ("LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw")


@pytest.fixture(scope="module")
def clearance() -> ArmClearance:
    body = load_body("nao-v5")
    return ArmClearance(body, BodyTree(body).link_frames)


def test_a_protected_arm_stops_at_the_head_and_comes_back(robot: Robot, clearance: ArmClearance) -> None:
    assert robot.motion("getCollisionProtectionEnabled", "LArm") is True
    start = robot.frame.position
    done = robot.motion("angleInterpolationWithSpeed", "LArm", INTO_HEAD, 0.5)
    courses = robot.run(4.0)
    assert done.done()
    least = [clearance.of("LArm", position) for position in courses]
    assert min(least) > 0.9 * ARM_MARGIN
    assert robot.motion("isCollision", "LArm") == "near"
    for joint, wanted in zip(ARM, INTO_HEAD, strict=False):  # as near as it can
        assert robot.angle(joint) == pytest.approx(wanted, abs=0.25)
    for before, after in itertools.pairwise(courses):
        assert max(abs(a - b) for a, b in zip(before, after, strict=True)) < 0.1
    back = [start[INDEX[joint]] for joint in ARM] + [0.0]
    robot.wait(robot.motion("angleInterpolationWithSpeed", "LArm", back, 0.5))
    assert [robot.angle(joint) for joint in ARM] == pytest.approx(back[:5], abs=1e-3)
    assert robot.motion("isCollision", "Arms") == "none"


def test_an_unprotected_arm_bumps(robot: Robot) -> None:
    assert robot.motion("setCollisionProtectionEnabled", "Arms", False) is True
    robot.motion("setAngles", "LArm", INTO_HEAD, 0.5)
    robot.run(4.0)
    assert robot.motion("isCollision", "LArm") == "collision"
    assert robot.motion("isCollision", "RArm") == "none"
    assert robot.motion("isCollision", "Arms") == "collision"
    robot.motion("setCollisionProtectionEnabled", "LArm", True)
    assert robot.motion("getCollisionProtectionEnabled", "RArm") is False
    robot.motion("setAngles", "LShoulderRoll", 0.6, 0.5)  # out of it again
    robot.run(2.0)
    assert robot.motion("isCollision", "LArm") == "none"


def test_the_dcm_is_not_held_back(robot: Robot) -> None:
    robot.motion("setAngles", "LArm", INTO_HEAD, 0.5)
    robot.run(4.0)
    now = robot.call("DCM", "getTime", 0)
    for joint, angle in zip(ARM, INTO_HEAD, strict=False):
        robot.call("DCM", "set", [f"{joint}/Position/Actuator/Value", "ClearAll", [[angle, now + 500]]])
    robot.run(1.0)
    assert robot.motion("isCollision", "LArm") == "collision"


@pytest.mark.parametrize("body", ["nao-v3", "nao-v3.2", "nao-v4", "nao-v5", "nao-v6"])
def test_the_vendors_postures_are_clear(body: str) -> None:
    sheet = load_body(body)
    clearance = ArmClearance(sheet, BodyTree(sheet).link_frames)
    for position in POSTURES.values():
        assert all(clearance.of(arm, position) >= 0.9 * ARM_MARGIN for arm in ("LArm", "RArm"))
