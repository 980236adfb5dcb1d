"""Balance over the foot that landed from a capture step, on a linear inverted pendulum and a rigid robot."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from bridge.body import load_body
from bridge.body.kinematics import CentreOfMass, FloatingBase
from walker.estimation.contact import Contacts, SupportState
from walker.gaits import gait_parameters, make_gait, standing_plan
from walker.gaits.plan import LandedFoot
from walker.gaits.pose import PoseMaker
from walker.mechanisms.capture_step import (
    CaptureParameters,
    LandedFootBalance,
    LandedFootEstimator,
    LandedFootParameters,
)
from walker.mechanisms.swing_foot import SwingFootOrientation, SwingFootOrientationParameters

DT = 0.01
OMEGA = 6.1
BODY = load_body("nao-v6")
P = LandedFootParameters()
STAND = standing_plan(make_gait("omni", gait_parameters("omni"), BODY))
LEFT_BACK = replace(
    STAND, phase="stop", support="both", capture="L", left=STAND.left._replace(x=STAND.left.x - 0.14)
)
LEFT_AHEAD = replace(LEFT_BACK, left=STAND.left._replace(x=STAND.left.x + 0.14))
LEFT, BOTH = Contacts(True, False), Contacts(True, True)
STILL = (0.0, 0.0, 0.0)


def last_capture_point(xi, roll, seconds):
    """Where the capture point of a pendulum goes whose ankle moves its ZMP by the turn beyond the lean, m."""
    balance = LandedFootBalance(P)
    for _ in range(round(seconds / DT)):
        balance.update(LEFT_BACK, LEFT, LandedFoot(xi, roll), STILL, DT)
        assert balance.roll is not None
        zmp = -(balance.roll + roll) / P.turn
        assert abs(zmp) <= P.max_offset + 1e-12
        xi = zmp + (xi - zmp) * math.exp(OMEGA * DT)
    return xi


@pytest.mark.parametrize("xi", [-0.015, 0.015])
@pytest.mark.parametrize("roll", [-0.1, 0.0, 0.2])
def test_a_capture_point_over_the_foot_comes_back_to_the_ankle(xi, roll):
    """xi' = omega (xi - k xi): xi_0 e^(-omega (k - 1) t), whatever the lean."""
    expected = xi * math.exp(-OMEGA * (P.gain - 1.0) * 0.5)
    assert last_capture_point(xi, roll, 0.5) == pytest.approx(expected, rel=0.2)


def test_beyond_the_farthest_centre_of_pressure_no_ankle_helps():
    assert last_capture_point(P.max_offset + 0.002, 0.0, 0.8) > 0.1


def test_the_ankle_follows_while_the_other_foot_hangs_and_not_once_both_stand():
    balance, seen = LandedFootBalance(P), []
    for k in range(100):
        contacts = BOTH if k < 10 or k >= 50 else LEFT
        balance.update(LEFT_BACK, contacts, LandedFoot(0.01, 0.1), (0.5, 0.5, 0.0), DT)
        seen.append((balance.roll is not None, balance.damping))
    follows = [k for k, (turned, _) in enumerate(seen) if turned]
    assert follows == [*range(math.ceil(P.landing_time / DT - 1e-9) - 1), *range(10, 51)]
    roll, pitch = P.damping
    assert seen[-1][1] == pytest.approx((0.5 * roll, 0.5 * pitch))
    assert seen[20][1] == (0.0, 0.0)
    assert seen[8][1] == (0.5 * roll, 0.0)  # before the other foot has left the floor


def test_after_a_step_ahead_nothing_is_damped():
    balance = LandedFootBalance(P)
    for _ in range(20):
        balance.update(LEFT_AHEAD, BOTH, LandedFoot(0.0, 0.0), (0.5, 0.5, 0.0), DT)
    assert balance.damping == (0.0, 0.0) and balance.roll is None


@pytest.mark.parametrize("roll", [-0.15, 0.1])
def test_the_landed_sole_goes_to_that_turn_and_the_other_comes_into_its_plane(roll):
    p = SwingFootOrientationParameters(return_rate=2.0, max_rate=4.0)
    control = SwingFootOrientation(p, P)
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
    control, seen = SwingFootOrientation(p, P), []
    lean = LandedFoot(0.0, -0.2)
    for k in range(120):
        contacts = LEFT if k < 20 else BOTH
        state = SupportState("both")
        turned = control.update((-0.2, 0.0), LEFT_AHEAD, state, contacts, DT, landed=lean, gyroscope=STILL)
        seen.append(turned["L"].roll)
    rates = [(a - b) / DT for a, b in pairwise(seen)]
    assert seen[20] == pytest.approx(0.2)
    assert rates[30] == pytest.approx(p.capture_roll_return_rate)
    assert rates[20 + round(P.standing_time / DT) + 5] == pytest.approx(p.standing_roll_return_rate)
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
    found = LandedFootEstimator(CaptureParameters(), FloatingBase(BODY)).update(
        angles, (roll, 0.0), (rate, 0.0, 0.0), replace(STAND, phase="stop", support="both", capture="L"), DT
    )
    at = r_y * math.cos(roll) - r_z * math.sin(roll) + middle
    speed = -rate * (r_z * math.cos(roll) + r_y * math.sin(roll))
    assert found is not None and STAND.pendulum is not None
    assert found.xi == pytest.approx(at + speed / STAND.pendulum.omega, abs=5e-4)
    assert found.roll == pytest.approx(roll + CaptureParameters().latency * rate)


def test_a_robot_that_made_no_capture_step_has_no_landed_foot():
    estimator = LandedFootEstimator(CaptureParameters(), FloatingBase(BODY))
    angles = PoseMaker(BODY, STAND).unlimited_angles(STAND)
    assert estimator.update(angles, (0.0, 0.0), STILL, STAND, DT) is None
