"""Leg inverse kinematics: undoes the forward kinematics, never lies about reach, never returns a NaN."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bridge.datasheet import BODIES, load_body
from bridge.joints import LEG_JOINTS
from walker.errors import UnreachableError
from walker.kinematics.inverse import hip_yaw_pitch_for_turn, solve_leg, solve_leg_with_hip, solve_legs
from walker.kinematics.leg import foot_in_torso, leg_chain
from walker.kinematics.limits import limit_violations
from walker.kinematics.transforms import homogeneous, rotation

V3 = load_body("nao-v3")
SIDES = ("L", "R")
CASES = [(name, 50_000 if name == "nao-v3" else 1_000) for name in BODIES]


def random_angles(body, side, n, seed):
    joints = [body.joints[name] for name in LEG_JOINTS[side]]
    low, high = [j.lower for j in joints], [j.upper for j in joints]
    return np.random.default_rng(seed).uniform(low, high, (n, 6))


def flat_foot(x, y, z, yaw=0.0):
    return homogeneous(rotation(0.0, 0.0, yaw), [x, y, z])


def sole_yaw(actual, wanted):
    """Turn of the actual foot about the wanted foot's normal."""
    return math.atan2(actual[:3, 0] @ wanted[:3, 1], actual[:3, 0] @ wanted[:3, 0])


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(("name", "n"), CASES)
def test_inverse_undoes_forward(name, n, side):
    # 100,000 poses on nao-v3. Only the sign of the knee is not in the pose: ranges start at about -5 degrees.
    body = load_body(name)
    angles = random_angles(body, side, n, seed=11)
    got, given_hip = np.empty_like(angles), np.empty_like(angles)
    for i, q in enumerate(angles.tolist()):
        pose, knee_sign = foot_in_torso(body, side, q), -1 if q[3] < 0.0 else 1
        got[i] = solve_leg(body, side, pose, knee_sign)
        given_hip[i] = solve_leg_with_hip(body, side, pose, q[0], knee_sign)
    assert np.abs(got - angles).max() < 1e-9
    assert np.abs(given_hip - angles).max() < 1e-9


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", BODIES)
def test_knee_bends_forward_unless_told_and_meets_the_pose_either_way(name, side):
    body = load_body(name)
    for q in random_angles(body, side, 300, seed=12).tolist():
        pose = foot_in_torso(body, side, q)
        for sign in (1, -1):
            angles = solve_leg(body, side, pose, sign)
            assert sign * angles[3] >= 0.0
            assert leg_chain(body, side, angles)[8] == pytest.approx(pose, abs=1e-12)
        assert solve_leg(body, side, pose)[3] >= 0.0


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", BODIES)
def test_given_hip_meets_position_and_normal(name, side):
    body = load_body(name)
    rng = np.random.default_rng(13)
    for q, hip in zip(
        random_angles(body, side, 300, seed=14).tolist(), rng.uniform(-1.1, 0.7, 300), strict=True
    ):
        pose = foot_in_torso(body, side, q)
        angles = solve_leg_with_hip(body, side, pose, hip)
        reached = leg_chain(body, side, angles)[8]
        assert angles[0] == hip
        assert reached[:3, 3] == pytest.approx(pose[:3, 3], abs=1e-12)
        assert reached[:3, 2] == pytest.approx(pose[:3, 2], abs=1e-12)


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


@pytest.mark.parametrize("half_angle", [-0.6, -0.2, 0.0, 0.1, 0.45])
def test_turned_hips_have_the_wanted_half_angle(half_angle):
    # (2.24): the x axes of frames L3 and R3, projected to the ground, are turned by -+ the half angle.
    phi = hip_yaw_pitch_for_turn(half_angle)
    assert math.tan(phi) == pytest.approx(math.tan(half_angle) / math.cos(math.pi / 4))
    for side, sign in (("L", -1.0), ("R", 1.0)):
        x_axis = leg_chain(V3, side, [phi, 0.0, 0.0, 0.0, 0.0, 0.0])[3][:3, 0]
        assert math.atan2(x_axis[1], x_axis[0]) == pytest.approx(sign * half_angle, abs=1e-14)


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
        assert yaws == pytest.approx([pair.yaw, pair.yaw], abs=1e-10)
        assert pair.spread == pytest.approx(0.0, abs=1e-12)


def test_drawn_up_legs_meet_positions_and_normals_and_own_up_to_the_rest():
    # Random legs over the whole ranges, both feet turned about their normals, out of any stance.
    left, right = random_angles(V3, "L", 300, seed=26), random_angles(V3, "R", 300, seed=27)
    right[:, 0] = left[:, 0]
    met = 0
    for q_left, q_right, turn in zip(
        left.tolist(), right.tolist(), np.random.default_rng(28).uniform(-0.3, 0.3, 300), strict=True
    ):
        turned = homogeneous(rotation(0.0, 0.0, turn), [0.0, 0.0, 0.0])
        wanted = {
            "L": foot_in_torso(V3, "L", q_left) @ turned,
            "R": foot_in_torso(V3, "R", q_right) @ turned,
        }
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


def test_straight_walking_leaves_no_yaw():
    pair = solve_legs(V3, flat_foot(0.03, 0.05, -0.25), flat_foot(-0.03, -0.05, -0.235))
    assert pair.yaw == pytest.approx(0.0, abs=1e-15)
    assert pair.left[0] == pytest.approx(0.0, abs=1e-15)


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
        for solve in (
            lambda t: solve_leg(body, side, t),
            lambda t: solve_leg_with_hip(body, side, t, -0.2),
        ):
            with pytest.raises(UnreachableError, match="out of reach") as caught:
                solve(target)
            assert caught.value.distance == pytest.approx(out, abs=1e-12)
            assert caught.value.side == side
        with pytest.raises(UnreachableError) as caught:
            solve_leg(body, side, homogeneous(np.eye(3), hip + 0.25 * shortest * direction))
        assert caught.value.distance == pytest.approx(0.75 * shortest, abs=1e-12)


def test_one_unreachable_foot_is_named():
    with pytest.raises(UnreachableError, match="right ankle") as caught:
        solve_legs(V3, flat_foot(0.0, 0.05, -0.25), flat_foot(0.0, -0.05, -0.5))
    assert caught.value.side == "R"


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
        solve_leg(V3, "L", target)
    assert caught.value.distance == math.inf


COORDINATE = st.floats(-0.4, 0.4) | st.sampled_from([0.0, 0.05, -0.05, -0.085, -0.185, -0.28774])
ANGLE = st.floats(-4.0, 4.0) | st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi])


@settings(max_examples=400, deadline=None)
@given(
    p=st.tuples(COORDINATE, COORDINATE, COORDINATE),
    angles=st.tuples(ANGLE, ANGLE, ANGLE),
    hip=st.floats(-3.0, 3.0),
    side=st.sampled_from(SIDES),
    knee_sign=st.sampled_from([1, -1]),
)
def test_an_answer_or_an_error_but_never_a_nan(p, angles, hip, side, knee_sign):
    target = homogeneous(rotation(*angles), p)
    lengths = V3.lengths
    centre = np.array([0.0, lengths.HipOffsetY if side == "L" else -lengths.HipOffsetY, -lengths.HipOffsetZ])
    distance = np.linalg.norm(np.subtract(p, centre))
    longest = lengths.ThighLength + lengths.TibiaLength
    out = max(distance - longest, lengths.TibiaLength - lengths.ThighLength - distance)
    try:
        six, five = (
            solve_leg(V3, side, target, knee_sign),
            solve_leg_with_hip(V3, side, target, hip, knee_sign),
        )
    except UnreachableError as error:
        assert error.distance == pytest.approx(out, abs=1e-12)
        return
    assert out <= 1e-11
    assert all(map(math.isfinite, six + five))
    # The position is met whatever the orientation: reach is a matter of distance alone.
    for found in (six, five):
        assert leg_chain(V3, side, found)[8][:3, 3] == pytest.approx(p, abs=1e-9)


def test_violations_name_the_joint_and_the_amount():
    # Table 1.2 of the thesis: RHipPitch from -101.54 deg, RKneePitch from -5.90 to 121.47 deg.
    q = [0.0, 0.0, math.radians(-101.54) - 0.01, math.radians(121.47) + 0.02, -0.5, 0.0]
    found = limit_violations(V3, "R", q)
    assert [v.joint for v in found] == ["RHipPitch", "RKneePitch"]
    assert [v.excess for v in found] == pytest.approx([-0.01, 0.02], abs=1e-6)
    assert limit_violations(V3, "R", [0.0, 0.0, -0.4, 0.8, -0.4, 0.0]) == ()


def test_ankle_roll_range_follows_the_ankle_pitch():
    # Vendor's anti-collision table: at AnklePitch 0.922755 the left AnkleRoll may go from 0 to 0.049916 rad.
    body = load_body("nao-v6")
    (found,) = limit_violations(body, "L", [0.0, 0.0, -0.5, 0.1, 0.922747, 0.1])
    assert found.joint == "LAnkleRoll"
    assert found.excess == pytest.approx(0.1 - 0.049916, abs=2e-5)
    assert limit_violations(body, "L", [0.0, 0.0, -0.5, 0.1, 0.0, 0.1]) == ()
