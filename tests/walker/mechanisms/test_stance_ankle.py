"""Offsets of the stance ankle against rate and lean of the torso."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import FloatingBase
from bridge.types import SIDES, Side, Vec2
from walker.gaits import gait_parameters, make_gait, standing_plan
from walker.gaits.pose import PoseMaker
from walker.mechanisms.stance_ankle import DampingParameters, LeanFeedbackParameters, StanceAnkle, StridePattern
from walker.stabilizer import in_foot_axes

DT = 0.01


def test_damping_turns_the_stance_ankle_with_the_fall_and_never_jumps() -> None:
    """Nose going down: toe down pushes the body back, so AnklePitch rises (`stabilization.torso.sign`)."""
    p = DampingParameters(roll=0.08, pitch=0.08)
    damping = StanceAnkle(p, LeanFeedbackParameters(pitch=0.5), DT, on_rate=True, on_lean=False)
    for _ in range(20):
        offsets = damping.update((0.0, 0.5, 0.0), (0.2, 0.2), "L", 0.5)
    assert offsets.pitch == pytest.approx((0.04, 0.0))
    before = offsets
    for support in ("both", "R", "L", "R"):
        after = damping.update((3.0, -3.0, 0.0), (0.0, 0.0), support, 0.5)
        for axis in (0, 1):
            for leg in (0, 1):
                assert abs(after[axis][leg] - before[axis][leg]) <= p.max_rate * DT + 1e-12
        before = after


def test_lean_feedback_turns_the_stance_ankle_against_the_lean() -> None:
    """The offsets right the torso as those of damping do (`torso.sign`); the swing ankle has none."""
    ankle = StanceAnkle(
        DampingParameters(pitch=0.1),
        LeanFeedbackParameters(roll=0.2, pitch=0.3, pattern_gain=0.0),
        DT,
        on_rate=False,
        on_lean=True,
    )
    for _ in range(20):
        offsets = ankle.update((1.0, 1.0, 1.0), (0.05, -0.1), "R", 0.5)
    assert offsets.pitch == pytest.approx((0.0, -0.03))
    assert offsets.roll == pytest.approx((0.0, 0.01))
    for _ in range(20):
        offsets = ankle.update((0.0, 0.0, 0.0), (0.05, -0.1), "both", 0.5)
    assert offsets == ((0.0, 0.0), (0.0, 0.0))


def test_the_pattern_of_a_stride_is_what_alternates_between_the_feet() -> None:
    """A lean of a + b on the left foot and a - b on the right one has the common part a, by arithmetic."""
    pattern, common, alternating = StridePattern(0.1), np.array([0.02, 0.15]), np.array([-0.03, 0.04])
    sides: tuple[tuple[Side, float], ...] = (("L", 1.0), ("R", -1.0))
    left: dict[tuple[Side, float], Vec2] = {}
    for _ in range(100):
        for side, sign in sides:
            for progress in (0.1, 0.6, 1.0):
                lean = common + sign * alternating * progress
                left[side, progress] = pattern.without((lean[0], lean[1]), side, progress)
    for each in left.values():
        assert each == pytest.approx(common, abs=1e-4)


@pytest.mark.parametrize("turn", [(0.02, 0.0), (0.0, 0.02), (-0.01, 0.015)])
def test_in_a_turn_the_ankles_turn_the_soles_about_the_axes_of_the_torso(turn: Vec2) -> None:
    """By the kinematics of the body: both soles point 0.3 rad outward, the torso between them."""
    body = load_body("nao-v6")
    base, gait = FloatingBase(body), make_gait("omni", gait_parameters("omni"), body)
    stand = standing_plan(gait)
    plan = replace(stand, left=stand.left._replace(yaw=0.3), right=stand.right._replace(yaw=-0.3))
    angles = list(PoseMaker(body, plan).unlimited_angles(plan))
    before = base.place(base.in_torso(angles), np.eye(4)).feet
    for side in SIDES:
        roll, pitch = in_foot_axes(plan, side, turn)
        angles[INDEX[f"{side}AnkleRoll"]] += roll
        angles[INDEX[f"{side}AnklePitch"]] += pitch
    after = base.place(base.in_torso(angles), np.eye(4)).feet
    for side in SIDES:
        turned = (after[side] @ np.linalg.inv(before[side]))[:3, :3]
        assert (turned[2, 1], turned[0, 2]) == pytest.approx(turn, abs=1e-3)
