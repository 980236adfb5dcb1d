"""The inverse kinematics of a plan honours the soles' yaw, checked with the forward kinematics of all links."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import BodyTree
from bridge.planar import Pose2D
from walker.gaits import Plan, SolePose, gait_parameters, make_gait, standing_plan
from walker.gaits.pose import PoseMaker

BODY = load_body("nao-v3")
TREE = BodyTree(BODY)
STAND = standing_plan(make_gait("dynamic", gait_parameters("dynamic"), BODY))
PSI_K = math.radians(45.0)
"""Slant of the HipYawPitch axis, data sheet."""


def yawed(plan: Plan, left: float, right: float) -> Plan:
    return replace(plan, left=plan.left._replace(yaw=left), right=plan.right._replace(yaw=right))


def feet_as_placed(angles: tuple[float, ...]) -> tuple[float, float, np.ndarray]:
    """By the forward kinematics: the feet's yaws against the line between them, and the way from R to L.

    Returns:
        Yaw of the left and the right foot, zero where they point across the line between the ankles, rad; way
        seen from the right foot, x and y, m.
    """
    frames = TREE.link_frames(angles)
    left, right = frames["LAnkleRoll"], frames["RAnkleRoll"]
    for foot in (left, right):
        np.testing.assert_allclose(foot[:3, 2], (0.0, 0.0, 1.0), atol=1e-9)
    return relative(left[:2, 3], right[:2, 3], yaw(left), yaw(right))


def feet_as_planned(plan: Plan) -> tuple[float, float, np.ndarray]:
    """The same by the plan."""
    left, right = plan.left, plan.right
    return relative(np.array([left.x, left.y]), np.array([right.x, right.y]), left.yaw, right.yaw)


def relative(
    left: np.ndarray, right: np.ndarray, left_yaw: float, right_yaw: float
) -> tuple[float, float, np.ndarray]:
    x, y = left - right
    line = math.atan2(-x, y)
    c, s = math.cos(right_yaw), math.sin(right_yaw)
    way = np.array([c * x + s * y, c * y - s * x])
    return math.remainder(left_yaw - line, math.tau), math.remainder(right_yaw - line, math.tau), way


def yaw(frame: np.ndarray) -> float:
    return math.atan2(frame[1, 0], frame[0, 0])


@pytest.mark.parametrize("half", [-0.2, -0.05, 0.1, 0.3])
def test_half_the_angle_between_the_soles_goes_to_each_leg(half: float) -> None:
    """Thesis 2.24: both hips share one motor, so the soles turn by equal and opposite half angles."""
    left, right, _ = feet_as_placed(PoseMaker(BODY, STAND).unlimited_angles(yawed(STAND, half, -half)))
    assert left == pytest.approx(half, abs=1e-4)
    assert right == pytest.approx(-half, abs=1e-4)


def test_the_motor_angle_of_straight_legs_is_that_of_the_closed_form() -> None:
    """Thesis 2.24: phi_2 = atan(tan(phi_b) / cos(psi_k)), for legs that hang straight down from their hips."""
    apart, half = BODY.lengths.HipOffsetY, math.radians(10.0)
    straight = replace(
        STAND,
        left=SolePose(0.0, apart),
        right=SolePose(0.0, -apart),
        hip_height=BODY.lengths.ThighLength + BODY.lengths.TibiaLength + BODY.lengths.FootHeight - 2e-3,
        com=(0.0, 0.0),
    )
    turned = yawed(straight, -half, half)
    angle = PoseMaker(BODY, straight).unlimited_angles(turned)[INDEX["LHipYawPitch"]]
    assert abs(angle) == pytest.approx(math.atan(math.tan(half) / math.cos(PSI_K)), rel=0.02)


@pytest.mark.parametrize(("by_pose", "tolerance"), [(False, 1e-4), (True, 5e-3)])
@pytest.mark.parametrize(("left", "right"), [(0.25, 0.0), (0.0, -0.25), (0.1, -0.2), (-0.2, 0.0)])
def test_feet_of_a_turning_step_stand_as_planned(
    left: float, right: float, by_pose: bool, tolerance: float
) -> None:
    """One foot ahead of the other and the mass to the side.

    With `by_pose` the mass of the pose is still on its way when the torso is turned, which leaves 0.3 degrees.
    """
    plan = replace(yawed(STAND, left, right), com=(0.02, 0.03))
    plan = replace(plan, left=plan.left._replace(x=0.04))
    placed = feet_as_placed(PoseMaker(BODY, STAND, by_pose=by_pose).unlimited_angles(plan))
    planned = feet_as_planned(plan)
    assert placed[0] - placed[1] == pytest.approx(planned[0] - planned[1], abs=1e-9)
    assert placed[:2] == pytest.approx(planned[:2], abs=tolerance)
    np.testing.assert_allclose(placed[2], planned[2], atol=tolerance * math.hypot(*planned[2]))


def test_a_plan_that_is_turned_and_moved_as_a_whole_asks_for_the_same_joint_angles() -> None:
    plan = replace(yawed(STAND, 0.1, -0.05), com=(0.01, 0.02))
    pose = PoseMaker(BODY, STAND)
    moved = plan.transformed(Pose2D(1.2, -0.7, 2.0))
    np.testing.assert_allclose(pose.unlimited_angles(moved), pose.unlimited_angles(plan), atol=1e-9)
