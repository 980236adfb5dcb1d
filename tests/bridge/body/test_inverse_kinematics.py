"""Leg inverse kinematics: undoes the forward kinematics, never lies about reach, never returns a NaN."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bridge.body import BODIES, load_body
from bridge.body.inverse_kinematics import FootPose, LegPair, UnreachableError
from bridge.body.inverse_kinematics import solve_legs as solve
from bridge.body.joints import LEG_JOINTS
from bridge.body.kinematics import foot_in_torso, homogeneous
from bridge.body.leg_limits import limit_violations
from bridge.rotations import rotation
from tests.bridge.body.thesis_leg import leg_chain

V3 = load_body("nao-v3")
SIDES = ("L", "R")
CASES = [(name, 20_000 if name == "nao-v3" else 1_000) for name in BODIES]
MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])


def solve_legs(body, left, right) -> LegPair:
    """From homogeneous transforms."""
    return solve(body, FootPose.of(left), FootPose.of(right))


def random_angles(body, side, n, seed):
    joints = [body.joints[name] for name in LEG_JOINTS[side]]
    low, high = [j.lower for j in joints], [j.upper for j in joints]
    return np.random.default_rng(seed).uniform(low, high, (n, 6))


def solve_leg(body, side, pose):
    """One leg, the other one its mirror image: they share their HipYawPitch, so both poses are met whole."""
    mirrored = MIRROR @ pose @ MIRROR
    pair = solve_legs(body, *((pose, mirrored) if side == "L" else (mirrored, pose)))
    return pair.left if side == "L" else pair.right


def flat_foot(x, y, z, yaw=0.0):
    return homogeneous(rotation(0.0, 0.0, yaw), [x, y, z])


def sole_yaw(actual, wanted):
    """Turn of the actual foot about the wanted foot's normal."""
    return math.atan2(actual[:3, 0] @ wanted[:3, 1], actual[:3, 0] @ wanted[:3, 0])


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(("name", "n"), CASES)
def test_inverse_undoes_forward(name, n, side):
    # Only the sign of the knee is not in the pose: ranges start at about -5 degrees, a walk bends it forward.
    body = load_body(name)
    angles = random_angles(body, side, n, seed=11)
    angles[:, 3] = np.abs(angles[:, 3])
    got = np.array([solve_leg(body, side, foot_in_torso(body, side, q)) for q in angles.tolist()])
    assert np.abs(got - angles).max() < 1e-9


def test_symmetric_squat_is_the_isosceles_triangle():
    # With thigh = shank = l and the foot flat below the hip: cos(knee / 2) = d / 2l, hip = ankle = -knee / 2.
    lengths = V3.lengths
    d = 0.17
    thigh, tibia = lengths.ThighLength, lengths.TibiaLength
    knee = math.pi - math.acos((thigh**2 + tibia**2 - d**2) / (2.0 * thigh * tibia))
    hip = -math.acos((thigh**2 + d**2 - tibia**2) / (2.0 * thigh * d))
    for side, y in (("L", 0.05), ("R", -0.05)):
        angles = solve_leg(V3, side, flat_foot(0.0, y, -lengths.HipOffsetZ - d))
        assert angles == pytest.approx((0.0, 0.0, hip, knee, -hip - knee, 0.0), abs=1e-14)


def test_foot_to_the_side_turns_the_hip_by_the_slope():
    # psi_4 = atan2(y, -z) of the ankle in frame 3, and a flat sole takes it back at the ankle.
    y, z = 0.03, -0.17
    target = flat_foot(0.0, 0.05 + y, -0.085 + z)
    angles = solve_leg(V3, "L", target)
    assert angles[0] == pytest.approx(0.0, abs=1e-14)
    assert angles[1] == pytest.approx(math.atan2(y, -z), abs=1e-14)
    assert angles[5] == pytest.approx(-math.atan2(y, -z), abs=1e-14)


@pytest.mark.parametrize("name", BODIES)
def test_both_legs_with_one_hip_angle(name):
    body = load_body(name)
    left, right = random_angles(body, "L", 500, seed=15), random_angles(body, "R", 500, seed=16)
    right[:, 0] = left[:, 0]
    left[:, 3], right[:, 3] = np.abs(left[:, 3]), np.abs(right[:, 3])
    for q_left, q_right in zip(left.tolist(), right.tolist(), strict=True):
        pair = solve_legs(body, foot_in_torso(body, "L", q_left), foot_in_torso(body, "R", q_right))
        assert pair.left == pytest.approx(q_left, abs=1e-8)
        assert pair.right == pytest.approx(q_right, abs=1e-8)
        assert pair.yaw == pytest.approx(0.0, abs=1e-9)


def test_feet_turned_unequally_keep_their_angle_and_share_the_rest():
    rng = np.random.default_rng(17)
    for _ in range(300):
        x_l, x_r, d_l, d_r = rng.uniform(-0.04, 0.04, 4)
        wanted = {
            "L": flat_foot(x_l, 0.055 + abs(d_l), -0.25, rng.uniform(-0.1, 0.5)),
            "R": flat_foot(x_r, -0.055 - abs(d_r), -0.26, rng.uniform(-0.5, 0.1)),
        }
        pair = solve_legs(V3, wanted["L"], wanted["R"])
        assert pair.left[0] == pair.right[0]
        yaws = []
        for side, angles in (("L", pair.left), ("R", pair.right)):
            reached = leg_chain(V3, side, angles)[8]
            assert reached[:3, 3] == pytest.approx(wanted[side][:3, 3], abs=1e-12)
            assert reached[:3, 2] == pytest.approx(wanted[side][:3, 2], abs=1e-12)
            yaws.append(sole_yaw(reached, wanted[side]))
        assert yaws == pytest.approx([pair.yaw, pair.yaw], abs=1e-9)
        assert pair.spread == pytest.approx(0.0, abs=1e-9)


def test_drawn_up_legs_meet_positions_and_normals_and_own_up_to_the_rest():
    # Random legs over the whole ranges, both feet turned about their normals, out of any stance.
    left, right = random_angles(V3, "L", 300, seed=26), random_angles(V3, "R", 300, seed=27)
    right[:, 0] = left[:, 0]
    met = 0
    for q_left, q_right, turn in zip(
        left.tolist(), right.tolist(), np.random.default_rng(28).uniform(-0.3, 0.3, 300), strict=True
    ):
        turned = homogeneous(rotation(0.0, 0.0, turn), [0.0, 0.0, 0.0])
        wanted = {"L": foot_in_torso(V3, "L", q_left) @ turned, "R": foot_in_torso(V3, "R", q_right) @ turned}
        pair = solve_legs(V3, wanted["L"], wanted["R"])
        yaws = []
        for side, angles in (("L", pair.left), ("R", pair.right)):
            reached = leg_chain(V3, side, angles)[8]
            assert reached[:3, 3:] == pytest.approx(wanted[side][:3, 3:], abs=1e-12)
            assert reached[:3, 2] == pytest.approx(wanted[side][:3, 2], abs=1e-12)
            yaws.append(sole_yaw(reached, wanted[side]))
        assert math.remainder(yaws[0] - yaws[1] - pair.spread, math.tau) == pytest.approx(0.0, abs=1e-9)
        met += abs(pair.spread) < 1e-9
    # A shared angle exists for all of these; the search may miss one whose zeros lie close together.
    assert met > 290


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", BODIES)
def test_unreachable_targets_say_by_how_much(name, side):
    body = load_body(name)
    lengths, sign = body.lengths, 1.0 if side == "L" else -1.0
    hip = np.array([0.0, sign * lengths.HipOffsetY, -lengths.HipOffsetZ])
    longest = lengths.ThighLength + lengths.TibiaLength
    shortest = abs(lengths.ThighLength - lengths.TibiaLength)
    rng = np.random.default_rng(18)
    for out in (1e-9, 1e-4, 0.02, 1.0):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        target = homogeneous(rotation(0.1, -0.2, 0.3), hip + (longest + out) * direction)
        with pytest.raises(UnreachableError, match="out of reach") as caught:
            solve_leg(body, side, target)
        assert caught.value.distance == pytest.approx(out, abs=1e-12)
        with pytest.raises(UnreachableError) as caught:
            solve_leg(body, side, homogeneous(np.eye(3), hip + 0.25 * shortest * direction))
        assert caught.value.distance == pytest.approx(0.75 * shortest, abs=1e-12)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", BODIES)
def test_a_fully_stretched_leg_is_in_reach(name, side):
    body = load_body(name)
    rng = np.random.default_rng(19)
    for q in random_angles(body, side, 200, seed=20).tolist():
        q[3] = 0.0
        pose = foot_in_torso(body, side, q)
        pose[:3, 3] += rng.uniform(-1e-16, 1e-16, 3)
        # The square root at the turning point: 1e-16 m of rounding shows as 1e-7 rad in the knee.
        assert solve_leg(body, side, pose) == pytest.approx(q, abs=1e-6)


@pytest.mark.parametrize("row", range(3))
@pytest.mark.parametrize("column", range(4))
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_target_that_is_not_finite_is_unreachable(row, column, bad):
    target = flat_foot(0.0, 0.05, -0.25)
    target[row, column] = bad
    with pytest.raises(UnreachableError, match="not a finite pose") as caught:
        solve_legs(V3, target, flat_foot(0.0, -0.05, -0.25))
    assert caught.value.distance == math.inf


COORDINATE = st.floats(-0.4, 0.4) | st.sampled_from([0.0, 0.05, -0.05, -0.085, -0.185, -0.28774])
ANGLE = st.floats(-4.0, 4.0) | st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi])


@settings(max_examples=400)
@given(
    p=st.tuples(COORDINATE, COORDINATE, COORDINATE),
    angles=st.tuples(ANGLE, ANGLE, ANGLE),
    side=st.sampled_from(SIDES),
)
def test_an_answer_or_an_error_but_never_a_nan(p, angles, side):
    target = homogeneous(rotation(*angles), p)
    lengths = V3.lengths
    centre = np.array([0.0, lengths.HipOffsetY if side == "L" else -lengths.HipOffsetY, -lengths.HipOffsetZ])
    distance = np.linalg.norm(np.subtract(p, centre))
    longest = lengths.ThighLength + lengths.TibiaLength
    out = max(distance - longest, lengths.TibiaLength - lengths.ThighLength - distance)
    try:
        found = solve_leg(V3, side, target)
    except UnreachableError as error:
        assert error.distance == pytest.approx(out, abs=1e-12)
        return
    assert out <= 1e-11
    assert all(map(math.isfinite, found))
    # The position is met whatever the orientation: reach is a matter of distance alone.
    assert leg_chain(V3, side, found)[8][:3, 3] == pytest.approx(p, abs=1e-9)


def test_ankle_roll_range_follows_the_ankle_pitch():
    # Vendor's anti-collision table: at AnklePitch 0.922755 the left AnkleRoll may go from 0 to 0.049916 rad.
    body = load_body("nao-v6")
    (found,) = limit_violations(body, "L", [0.0, 0.0, -0.5, 0.1, 0.922747, 0.1])
    assert found.joint == "LAnkleRoll"
    assert found.excess == pytest.approx(0.1 - 0.049916, abs=2e-5)
    assert limit_violations(body, "L", [0.0, 0.0, -0.5, 0.1, 0.0, 0.1]) == ()
