from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.body import BODIES, load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import (
    COUPLED_TO,
    absent_joints,
    coupled_limits,
    joint_no_load_speed,
    joint_nominal_torque,
    joint_stall_torque,
    limits,
)
from bridge.body.sole import foot_centre, sole_hull, sole_outline
from bridge.types import Side

# Joint side of the vendor's 2010 motor page: deg/s and N m, without gear losses.
V3_DRIVES = {
    "HipYawPitch": (238.45, 11.97, 2.47),
    "HipRoll": (238.45, 11.97, 2.47),
    "AnkleRoll": (238.45, 11.97, 2.47),
    "HipPitch": (366.83, 7.78, 1.61),
    "KneePitch": (366.83, 7.78, 1.61),
    "AnklePitch": (366.83, 7.78, 1.61),
    "ShoulderPitch": (473.72, 2.27, 0.57),
    "ElbowYaw": (473.72, 2.27, 0.57),
    "ShoulderRoll": (412.19, 2.61, 0.66),
    "ElbowRoll": (412.19, 2.61, 0.66),
}


@pytest.mark.parametrize("side", ["L", "R"])
@pytest.mark.parametrize("joint", V3_DRIVES)
def test_drives_of_the_v3(side: str, joint: str) -> None:
    body = load_body("nao-v3")
    speed, stall, nominal = V3_DRIVES[joint]
    # 0.4 %: the page's own speeds behind 150.27:1 belong to 11864 rpm, its motors turn at 11900.
    assert math.degrees(joint_no_load_speed(body, side + joint)) == pytest.approx(speed, rel=0.004)
    assert joint_stall_torque(body, side + joint) == pytest.approx(stall, abs=0.015)
    assert joint_nominal_torque(body, side + joint) == pytest.approx(nominal, abs=0.015)


def test_leg_drives_of_the_v6() -> None:
    """The vendor's V6 motors behind the gear ratios: 259.3 and 398.9 deg/s, 13.08 and 8.51 N m."""
    body = load_body("nao-v6")
    assert math.degrees(joint_no_load_speed(body, "LHipRoll")) == pytest.approx(259.3, abs=0.1)
    assert math.degrees(joint_no_load_speed(body, "RKneePitch")) == pytest.approx(398.9, abs=0.1)
    assert joint_stall_torque(body, "LAnkleRoll") == pytest.approx(13.08, abs=0.01)
    assert joint_stall_torque(body, "LAnklePitch") == pytest.approx(8.51, abs=0.01)
    assert math.degrees(joint_no_load_speed(body, "LShoulderPitch")) == pytest.approx(455.2, abs=0.1)


def test_absent_joints() -> None:
    assert absent_joints(load_body("nao-v3")) == ("LWristYaw", "RWristYaw", "LHand", "RHand")
    for name in BODIES[1:]:
        assert absent_joints(load_body(name)) == ()


def test_coupled_limits_at_the_published_points() -> None:
    body = load_body("nao-v6")
    assert coupled_limits(body, "LAnkleRoll", -1.189442) == pytest.approx((-0.049916, 0.075049))
    assert coupled_limits(body, "RAnkleRoll", -0.700051) == pytest.approx((-0.220086, 0.397935))
    assert coupled_limits(body, "LAnkleRoll", 0.922755) == pytest.approx((0.0, 0.049916))
    # Beyond the table: as at its end. Within the flat part: the joint's own range.
    assert coupled_limits(body, "LAnkleRoll", 2.0) == pytest.approx((0.0, 0.049916))
    assert coupled_limits(body, "LAnkleRoll", -0.2) == pytest.approx((-0.39788, 0.768992))
    # Half way between two points.
    half = coupled_limits(body, "LAnkleRoll", (0.349938 + 0.922755) / 2)
    assert half == pytest.approx((-0.397935 / 2, (0.550477 + 0.049916) / 2))
    for yaw in (1.089958, -1.089958):
        assert coupled_limits(body, "HeadPitch", yaw) == pytest.approx((-0.430049, 0.300022))
    assert coupled_limits(body, "LKneePitch", 1.0) == limits(body, "LKneePitch")


@given(name=st.sampled_from(BODIES), joint=st.sampled_from(sorted(COUPLED_TO)), at=st.floats(-4.0, 4.0))
def test_coupled_ranges_are_never_empty_nor_wider_than_the_joint_s(name: str, joint: str, at: float) -> None:
    body = load_body(name)
    lower, upper = coupled_limits(body, joint, at)
    assert lower < upper
    own_lower, own_upper = limits(body, joint)
    assert own_lower <= lower
    assert upper <= own_upper


def _area(outline: np.ndarray) -> float:
    following = np.roll(outline, -1, axis=0)
    return 0.5 * float(np.sum(outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]))


@pytest.mark.parametrize("name", BODIES)
def test_soles(name: str) -> None:
    body = load_body(name)
    left, right = sole_outline(body, "L"), sole_outline(body, "R")
    assert left.shape == right.shape == (20, 2)
    assert _area(left) == pytest.approx(_area(right))
    assert _area(left) > 0.0
    # B-Human's robot dimensions: front 100, back 50, outer 50.02, inner 38.77 mm.
    np.testing.assert_allclose(left.max(axis=0), (0.100, 0.05002), atol=1e-3)
    np.testing.assert_allclose(left.min(axis=0), (-0.050, -0.03877), atol=1e-3)
    assert {(x, -y) for x, y in left} == {(x, y) for x, y in right}


@pytest.mark.parametrize("side", ["L", "R"])
def test_hull_is_convex_and_holds_the_outline_and_the_sensors(side: Side) -> None:
    body = load_body("nao-v3")
    hull = sole_hull(body, side)
    edges = np.roll(hull, -1, axis=0) - hull
    following = np.roll(edges, -1, axis=0)
    assert np.all(edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] > 0.0)
    outline = sole_outline(body, side)
    assert len(hull) < len(outline)
    sensors = np.array(body.fsr.L if side == "L" else body.fsr.R)[:, :2]
    centre = foot_centre(body, side)[None]
    for point in np.vstack([outline, sensors, centre]):
        to_point = point - hull
        assert np.all(edges[:, 0] * to_point[:, 1] - edges[:, 1] * to_point[:, 0] >= -1e-12)


def test_postures() -> None:
    assert set(POSTURES) == {
        "Stand", "StandInit", "StandZero", "Crouch", "Sit", "SitRelax", "LyingBelly", "LyingBack",
    }  # fmt: skip
    init = dict(zip(JOINTS, POSTURES["StandInit"], strict=True))
    assert init["LHipPitch"] == init["RHipPitch"] == -0.45
    assert init["LKneePitch"] == init["RKneePitch"] == 0.7
    assert init["RElbowRoll"] == 1.01
    assert init["LHand"] == init["RHand"] == 0.25
    assert POSTURES["Sit"][INDEX["LHipYawPitch"]] == -0.607422
    assert POSTURES["LyingBack"][INDEX["RKneePitch"]] == 1.738064


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("posture", POSTURES)
def test_postures_keep_the_limits_and_couplings(name: str, posture: str) -> None:
    # Also a check of the ankle tables' signs: Crouch stands at an end of them.
    body = load_body(name)
    position = POSTURES[posture]
    for joint in set(JOINTS) - set(absent_joints(body)):
        other = position[INDEX[COUPLED_TO[joint]]] if joint in COUPLED_TO else 0.0
        lower, upper = coupled_limits(body, joint, other)
        assert lower - 1e-4 <= position[INDEX[joint]] <= upper + 1e-4, joint
