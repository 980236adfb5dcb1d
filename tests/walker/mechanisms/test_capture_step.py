"""The capture step: trigger and footholds by the inverted pendulum, hips and arms, balance after it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.body.kinematics import CentreOfMass, FloatingBase
from bridge.body.quantities import GRAVITY
from bridge.body.sole import foot_centre
from bridge.planar import Pose2D
from tests.plans import supported_plan
from tests.states import rigid_state
from walker.estimation.contact import Contacts, SupportState
from walker.gaits import GaitCommand, gait_parameters, make_gait, standing_plan
from walker.gaits.plan import CaptureStep, Feedback, LandedFoot, SolePose
from walker.gaits.pose import ARMS, PoseMaker
from walker.mechanisms.capture_step import (
    BackwardStep,
    BackwardStepParameters,
    CaptureEstimator,
    CaptureParameters,
    LandedFootBalance,
    LandedFootParameters,
    landed_foot,
)
from walker.mechanisms.swing_foot import SwingFootOrientation, SwingFootOrientationParameters

BODY = load_body("nao-v6")
P = gait_parameters("omni")
OMEGA = math.sqrt(GRAVITY / P.z)
TOE, HEEL = (max(x for x, _ in BODY.foot.sole), min(x for x, _ in BODY.foot.sole))
STAND = standing_plan(make_gait("omni", P, BODY))
ANGLES = PoseMaker(BODY, STAND).unlimited_angles(STAND)
WEIGHT = 50.0
LATENCY = 0.04


def tips(pitch, rate, load=WEIGHT):
    """What a robot that is turned as a whole by `pitch` (rad) and turns at `rate` (rad/s) is taken for."""
    estimator = CaptureEstimator(CaptureParameters(), FloatingBase(BODY), LATENCY)
    return estimator.update(rigid_state(BODY, ANGLES, (0.0, pitch), (0.0, rate, 0.0)), load, STAND, 0.01)


@pytest.mark.parametrize(("pitch", "edge"), [(0.1, TOE), (-0.1, HEEL)])
def test_a_stand_is_lost_when_the_capture_point_of_the_rigid_body_leaves_the_soles(pitch, edge):
    """Turned about the middle of the soles: x = r_x cos + r_z sin, x' = rate (r_z cos - r_x sin)."""
    _x, _y, z = CentreOfMass(BODY)(ANGLES)
    middle = foot_centre(BODY, "L")[0]
    ankle = P.zmp_x  # the stand has its mass so far ahead of the ankles
    r_x, r_z = ankle - middle, P.l_GH + BODY.lengths.FootHeight + BODY.lengths.HipOffsetZ + z
    at = r_x * math.cos(pitch) + r_z * math.sin(pitch) + middle
    lever = r_z * math.cos(pitch) - r_x * math.sin(pitch)
    rate = OMEGA * (edge - at) / lever
    step = math.copysign(0.03, edge)
    assert tips(pitch, rate - step) is None
    assert tips(pitch, rate + step, load=5.0) is None  # in the hand
    assert tips(pitch, rate + step, load=25.0) is not None  # one cell bears all, and reads what it can (V6)
    found = tips(pitch, rate + step)
    assert found is not None
    beyond = step * lever / OMEGA * math.exp(OMEGA * LATENCY)
    assert found.xi == pytest.approx((edge + beyond, 0.0), abs=1e-3)
    assert found.com == pytest.approx((at + LATENCY * (rate + step) * lever, 0.0), abs=1e-3)
    msgspec.msgpack.encode(
        found
    )  # the plan that follows goes out as telemetry, which takes no number of NumPy's


@pytest.mark.parametrize("capture", [None, "R"])
def test_no_capture_step_follows_a_step_of_the_walk_before_its_foot_has_come_to_rest(capture):
    """After a capture step another one may follow at once."""
    estimator = CaptureEstimator(CaptureParameters(), FloatingBase(BODY), LATENCY)
    swing = replace(STAND, phase="SSL", support="L", capture=capture)
    landed = replace(STAND, phase="stop", capture=capture)
    state = rigid_state(BODY, ANGLES, (0.0, -0.2), (0.0, -1.0, 0.0))
    found = [estimator.update(state, WEIGHT, plan, 0.01) is not None for plan in [swing, *[landed] * 20]]
    cycles = 1 if capture else 1 + math.ceil(CaptureParameters().min_time_after_step / 0.01)
    assert found.index(True) == pytest.approx(cycles, abs=1)
    assert all(found[found.index(True) :])


@pytest.mark.parametrize(("edge", "side"), [(TOE, 0.02), (HEEL, 0.02), (TOE, -0.02), (HEEL, -0.02)])
def test_the_foot_that_bears_less_lands_over_the_capture_point_and_the_feet_close_again(edge, side):
    """xi = p + (xi_0 - p) e^(w t) with the ZMP p on the edge over which the robot tips."""
    gait = make_gait("omni", P, BODY)
    state, plans = gait.initial(), []
    beyond = math.copysign(0.02, edge)
    for k in range(600):
        xi = edge + beyond * math.exp(OMEGA * 0.01 * k)
        steps = not plans or plans[-1].phase in ("SSL", "SSR")
        seen = CaptureStep((0.8 * edge, side), (xi, side)) if steps else None
        if plans and plans[-1].step:
            seen = None
        plan, state = gait.step(state, 0.01, GaitCommand(walk=False, feedback=Feedback(capture_step=seen)))
        plans.append(plan)
        if plan.phase == "stand":
            break
    assert plans[0].support == ("L" if side > 0.0 else "R")
    landed = next(plan for plan in plans if plan.step == 1)
    foot = landed.right if side > 0.0 else landed.left
    xi = edge + beyond * math.exp(OMEGA * (P.T_capture if edge > 0.0 else P.T_backward_capture))
    assert foot.x + HEEL < xi < foot.x + TOE
    inset = P.backward_capture_inset if edge == HEEL else 0.0
    assert abs(landed.left.y - landed.right.y) == pytest.approx(P.l_FA - inset, abs=0.02)
    highest = max(max(plan.left.z, plan.right.z) for plan in plans if plan.step == 0)
    assert highest == pytest.approx(P.backward_capture_lift if edge == HEEL else P.l_lift, rel=0.05)
    turned = Pose2D(0.3, -0.2, 2.5)  # where the walk began does not matter
    backward = [
        plan.transformed(turned).captures_backward
        for plan in plans
        if plan.capture and abs(plan.left.x - plan.right.x) > 1e-3
    ]
    assert backward and set(backward) == {edge == HEEL}
    for plan in plans:
        if plan.phase == "stand" or plan.step == 0:
            assert plan.capture == (None if plan.phase == "stand" else "R" if side > 0.0 else "L")
    last = plans[-1]
    assert last.phase == "stand"
    assert math.dist((last.left.x, last.left.y), (last.right.x, last.right.y)) == pytest.approx(
        P.l_FA, abs=1e-6
    )


DT = 0.01
DURATION = 0.2
P_BACK = BackwardStepParameters()
BEHIND, NEARER = -P_BACK.hip_behind - 0.02, -P_BACK.arm_behind + 0.01


def step(x, progress):
    """Plan of a capture step of the right foot to x, m."""
    return replace(STAND, phase="SSL", support="L", capture="R", progress=progress, right=SolePose(x, -0.05))


def moves(xi, x=-0.1, cycles=60, body=BODY):
    """Bend of the hips and swing of the arms by cycle, rad, in a step of 0.2 s and after it.

    The stance foot stands at (0, 0.05); the arms hang at first.
    """
    mechanism, bends, swings = BackwardStep(P_BACK, body), [], []
    for k in range(cycles):
        time = k * DT
        plan = step(x, time / DURATION)
        if time >= DURATION:
            plan = replace(plan, phase="stop", support="both")
        mechanism.update(plan, CaptureStep((0.0, 0.0), xi) if time < DURATION else None, DT)
        angles = [ARMS["LShoulderPitch"] if "ShoulderPitch" in name else 0.0 for name in JOINTS]
        before = angles.copy()
        mechanism.add(angles)
        change = {name: before[slot] - angles[slot] for name, slot in INDEX.items()}
        for joint, of in (("HipPitch", bends), ("ShoulderPitch", swings)):
            left, right = change.pop(f"L{joint}"), change.pop(f"R{joint}")
            assert left == right
            of.append(left)
        assert not any(change.values())
    return bends, swings


def test_both_hips_that_bend_by_one_angle_leave_the_feet_as_they_are_to_each_other():
    """The axes of both HipPitches are in line where HipRoll and HipYawPitch are 0 (data sheet)."""
    base = FloatingBase(BODY)
    angles = list(PoseMaker(BODY, STAND).unlimited_angles(replace(STAND, right=SolePose(-0.08, -0.05, 0.02))))
    for name in ("LHipRoll", "RHipRoll", "LHipYawPitch"):
        angles[INDEX[name]] = 0.0

    def feet(position):
        pose = base.place(base.in_torso(position), np.eye(4))
        return pose.feet["L"], pose.feet["R"]

    left, right = feet(angles)
    for name in ("LHipPitch", "RHipPitch"):
        angles[INDEX[name]] -= P_BACK.hip_angle
    bent_left, bent_right = feet(angles)
    assert np.linalg.solve(bent_left, bent_right) == pytest.approx(np.linalg.solve(left, right), abs=1e-9)
    # The torso has turned ahead by it, seen from a foot: nose down is positive about y.
    turn = np.linalg.solve(left.T, bent_left.T).T[:3, :3]
    assert math.atan2(-turn[0, 2], turn[0, 0]) == pytest.approx(P_BACK.hip_angle)


def test_a_strong_push_straight_back_bends_the_hips_until_the_foot_lands():
    found, _ = moves((BEHIND, 0.0))
    at = round(DURATION / DT)
    changes = [b - a for a, b in itertools.pairwise([0.0, *found])]
    assert max(found[:at]) == found[at - 1] == pytest.approx(P_BACK.hip_angle)
    assert np.argmax(found) == pytest.approx(P_BACK.hip_angle / P_BACK.hip_rate / DT, abs=1.0)
    assert max(changes) <= P_BACK.hip_rate * DT + 1e-12 and min(changes) >= -P_BACK.hip_return_rate * DT - 1e-12
    assert found[-1] == 0.0


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
def test_a_strong_push_straight_back_swings_both_arms_ahead_and_up_and_they_come_back_slowly(name):
    """Data sheet: ShoulderPitch is 0 with the arm straight ahead and negative above."""
    body = load_body(name)
    _, swings = moves((BEHIND, 0.0), cycles=500, body=body)
    highest = min(P_BACK.arm_angle, ARMS["LShoulderPitch"] - body.joints["LShoulderPitch"].lower)
    assert max(swings) == pytest.approx(highest)
    changes = [b - a for a, b in itertools.pairwise([0.0, *swings])]
    assert max(changes) <= P_BACK.arm_rate * DT + 1e-9 and min(changes) >= -P_BACK.arm_return_rate * DT - 1e-9
    assert np.argmax(swings) * DT == pytest.approx(highest / P_BACK.arm_rate, abs=0.03)
    assert swings[-1] == 0.0


@pytest.mark.parametrize("side", [-0.05, 0.05])
def test_a_push_to_a_side_leaves_the_hips(side):
    assert not any(moves((BEHIND, side))[0])


def test_what_the_capture_point_does_late_in_the_step_changes_nothing():
    mechanism = BackwardStep(P_BACK, BODY)
    for k in range(20):
        xi = (BEHIND, 0.0) if k < 5 else (NEARER, 0.05)
        mechanism.update(step(-0.1, k * DT / DURATION), CaptureStep((0.0, 0.0), xi), DT)
    assert mechanism.bend == P_BACK.hip_angle


OMEGA_LANDED = 6.1
P_LANDED = LandedFootParameters()
LEFT_BACK = replace(
    STAND, phase="stop", support="both", capture="L", left=STAND.left._replace(x=STAND.left.x - 0.14)
)
LEFT_AHEAD = replace(LEFT_BACK, left=STAND.left._replace(x=STAND.left.x + 0.14))
LEFT, BOTH = Contacts(True, False), Contacts(True, True)
STILL = (0.0, 0.0, 0.0)


def last_capture_point(xi, roll, seconds):
    """Where the capture point of a pendulum goes whose ankle moves its ZMP by the turn beyond the lean, m."""
    balance = LandedFootBalance(P_LANDED)
    for _ in range(round(seconds / DT)):
        balance.update(LEFT_BACK, LEFT, LandedFoot(xi, roll), STILL, DT)
        assert balance.roll is not None
        zmp = -(balance.roll + roll) / P_LANDED.turn
        assert abs(zmp) <= P_LANDED.max_offset + 1e-12
        xi = zmp + (xi - zmp) * math.exp(OMEGA_LANDED * DT)
    return xi


@pytest.mark.parametrize("xi", [-0.015, 0.015])
@pytest.mark.parametrize("roll", [-0.1, 0.0, 0.2])
def test_a_capture_point_over_the_foot_comes_back_to_the_ankle(xi, roll):
    """xi' = omega (xi - k xi): xi_0 e^(-omega (k - 1) t), whatever the lean."""
    expected = xi * math.exp(-OMEGA_LANDED * (P_LANDED.gain - 1.0) * 0.5)
    assert last_capture_point(xi, roll, 0.5) == pytest.approx(expected, rel=0.2)


def test_the_ankle_follows_while_the_other_foot_hangs_and_not_once_both_stand():
    balance, seen = LandedFootBalance(P_LANDED), []
    for k in range(100):
        contacts = BOTH if k < 10 or k >= 50 else LEFT
        balance.update(LEFT_BACK, contacts, LandedFoot(0.01, 0.1), (0.5, 0.5, 0.0), DT)
        seen.append((balance.roll is not None, balance.damping))
    follows = [k for k, (turned, _) in enumerate(seen) if turned]
    assert follows == [*range(math.ceil(P_LANDED.landing_time / DT - 1e-9) - 1), *range(10, 51)]
    roll, pitch = P_LANDED.damping
    assert seen[-1][1] == pytest.approx((0.5 * roll, 0.5 * pitch))
    assert seen[20][1] == (0.0, 0.0)
    assert seen[8][1] == (0.5 * roll, 0.0)  # before the other foot has left the floor


@pytest.mark.parametrize("roll", [-0.15, 0.1])
def test_the_landed_sole_goes_to_that_turn_and_the_other_comes_into_its_plane(roll):
    p = SwingFootOrientationParameters(return_rate=2.0, max_rate=4.0)
    control = SwingFootOrientation(p, P_LANDED)
    for _ in range(30):
        found = control.update(
            (roll, 0.0),
            LEFT_BACK,
            SupportState("both"),
            LEFT,
            DT,
            landed=LandedFoot(0.0, roll),
            gyroscope=STILL,
        )
    assert found["L"].roll == pytest.approx(-roll) == pytest.approx(found["R"].roll, abs=0.02)


def test_the_legs_right_the_torso_slowly_until_the_robot_stands_on_both_feet():
    p = SwingFootOrientationParameters(max_rate=4.0)
    control, seen = SwingFootOrientation(p, P_LANDED), []
    lean = LandedFoot(0.0, -0.2)
    for k in range(120):
        contacts = LEFT if k < 20 else BOTH
        state = SupportState("both")
        turned = control.update((-0.2, 0.0), LEFT_AHEAD, state, contacts, DT, landed=lean, gyroscope=STILL)
        seen.append(turned["L"].roll)
    rates = [(a - b) / DT for a, b in pairwise(seen)]
    assert seen[20] == pytest.approx(0.2)
    assert rates[30] == pytest.approx(p.capture_roll_return_rate)
    assert rates[20 + round(P_LANDED.standing_time / DT) + 5] == pytest.approx(p.standing_roll_return_rate)
    assert seen[-1] == 0.0


@pytest.mark.parametrize("roll", [-0.1, 0.1])
@pytest.mark.parametrize("rate", [-0.4, 0.0, 0.4])
def test_the_capture_point_of_a_rigid_robot_on_one_sole(roll, rate):
    """A body turned as a whole about x: y = r_y cos - r_z sin, y' = -rate (r_z cos + r_y sin)."""
    angles = PoseMaker(BODY, STAND).unlimited_angles(STAND)
    _x, y, z = CentreOfMass(BODY)(angles)
    middle = FloatingBase(BODY).centres["L"][1]
    r_y = y - STAND.left.y - middle
    r_z = z + STAND.hip_height + BODY.lengths.HipOffsetZ
    landed = replace(STAND, phase="stop", support="both", capture="L")
    state = rigid_state(BODY, angles, (roll, 0.0), (rate, 0.0, 0.0))
    found = landed_foot(state, landed, FloatingBase(BODY), LATENCY)
    at = r_y * math.cos(roll) - r_z * math.sin(roll) + middle
    speed = -rate * (r_z * math.cos(roll) + r_y * math.sin(roll))
    assert found is not None and STAND.pendulum is not None
    assert found.xi == pytest.approx(at + speed / STAND.pendulum.omega, abs=5e-4)
    assert found.roll == pytest.approx(roll + LATENCY * rate)


def test_after_a_capture_step_back_both_soles_lie_in_one_plane_until_the_torso_is_upright() -> None:
    """With the torso leaning back by 20 degrees both soles are turned by it about one axis, and end level."""
    p = SwingFootOrientationParameters(return_rate=2.0, max_rate=4.0)
    control, lean = SwingFootOrientation(p, LandedFootParameters()), math.radians(-20.0)
    swing = replace(supported_plan("L"), capture="R", right=SolePose(-0.1, -0.1))
    for k in range(40):
        found = control.update((0.0, lean), swing, SupportState("L", progress=k / 40), LEFT, DT)
    assert found["R"].pitch == pytest.approx(-lean)
    assert found["R"].lift == pytest.approx(-0.1 * lean)  # 0.1 m behind, the ground is so much higher
    landed = replace(swing, phase="stop", support="both")
    turns = []
    for _ in range(60):
        found = control.update((0.0, lean), landed, SupportState("both"), LEFT, DT)
        turns.append((found["L"].pitch, found["R"].pitch))
        assert found["L"].lift == 0.0
    assert min(abs(left - right) for left, right in turns if right > 0.1) <= 2.0 * p.return_rate * DT
    assert turns[-1] == (0.0, 0.0)
