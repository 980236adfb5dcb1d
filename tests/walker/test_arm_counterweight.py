"""The arm that goes out while a robot tips over its stance foot; both arms in a capture step back."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, N_JOINTS
from bridge.body.kinematics import CentreOfMass
from walker.gaits import gait_parameters, make_gait, standing_plan
from walker.gaits.plan import SolePose
from walker.gaits.pose import ARMS
from walker.mechanisms.tipping import ArmCounterweight, ArmCounterweightParameters

DT = 0.01
P = ArmCounterweightParameters()
STAND = standing_plan(make_gait("omni", gait_parameters("omni"), load_body("nao-v6")))
OUTWARD = {"L": 1.0, "R": -1.0}
"""Sign of a ShoulderRoll that lifts the arm to its own side (data sheet of the NAO: positive to the left)."""


def hanging():
    """25 angles with the arms of a walk."""
    angles = [0.0] * N_JOINTS
    for joint, angle in ARMS.items():
        angles[INDEX[joint]] = angle
    return angles


def moved(body, signals, plan=STAND):
    """Angles in each cycle.

    Args:
        body: data sheet.
        signals: support and tipping, m, by cycle.
        plan: in force.
    """
    arm, found = ArmCounterweight(P, body), []
    for support, tipping in signals:
        angles = hanging()
        arm.update(angles, plan, support, tipping, DT)
        found.append(angles)
    return found


def outward(angles, side):
    """Angle of a shoulder beside that of a walk, rad."""
    slot = INDEX[f"{side}ShoulderRoll"]
    return OUTWARD[side] * (angles[slot] - hanging()[slot])


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
@pytest.mark.parametrize(("support", "side"), [("L", "R"), ("R", "L")])
def test_the_arm_opposite_to_the_stance_foot_goes_out_and_brings_the_mass_to_its_side(name, support, side):
    body = load_body(name)
    found = moved(body, [(support, 0.3)] * 60)
    rates = [outward(b, side) - outward(a, side) for a, b in itertools.pairwise(found)]
    assert max(rates) <= P.max_rate * DT + 1e-9
    assert outward(found[-1], side) == pytest.approx(P.max_angle)
    assert outward(found[-1], support) == 0.0
    com = CentreOfMass(body)
    shift = float(com(found[-1])[1]) - float(com(hanging())[1])
    assert OUTWARD[side] * shift > 0.003
    for slot in set(range(N_JOINTS)) - {INDEX[f"{side}ShoulderRoll"]}:
        assert found[-1][slot] == hanging()[slot]


def test_up_to_the_bound_nothing_moves_and_beyond_it_in_proportion():
    body = load_body("nao-v6")
    assert moved(body, [("L", P.deviation)] * 30)[-1] == hanging()
    assert outward(moved(body, [("L", P.deviation + 0.02)] * 30)[-1], "R") == pytest.approx(0.02 * P.gain)


@pytest.mark.parametrize("after", ["both", "R", "L"])
def test_the_arm_comes_back_slowly_whatever_foot_stands_then(after):
    found = moved(load_body("nao-v6"), [("L", 0.3)] * 60 + [(after, 0.0)] * 130)
    away = [outward(angles, "R") for angles in found[59:]]
    steps = [a - b for a, b in itertools.pairwise(away)]
    assert max(steps) <= P.return_rate * DT + 1e-9 and min(steps) >= 0.0
    assert away[-1] == 0.0


def test_no_joint_leaves_its_range():
    body = load_body("nao-v6")
    angles = hanging()
    angles[INDEX["RShoulderRoll"]] = -1.0  # an arm that is up already
    ArmCounterweight(ArmCounterweightParameters(max_rate=500.0), body).update(angles, STAND, "L", 0.3, DT)
    assert angles[INDEX["RShoulderRoll"]] == body.joints["RShoulderRoll"].lower


def capture_step(x):
    """Plan of a capture step of the right foot to x, m."""
    return replace(STAND, phase="SSL", support="L", capture="R", right=SolePose(x, -0.1))


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
def test_in_a_capture_step_back_both_arms_swing_ahead_and_up_and_come_back_slowly(name):
    """Data sheet: ShoulderPitch is 0 with the arm straight ahead and negative above."""
    body = load_body(name)
    arm, found = ArmCounterweight(P, body), []
    landed = replace(capture_step(-0.1), phase="stop", support="both")
    for k in range(500):
        plan = capture_step(-0.1) if k < 10 else landed if k < 100 else STAND
        angles = hanging()
        arm.update(angles, plan, plan.support, 0.0, DT)
        found.append(angles)
    for side in ("L", "R"):
        slot = INDEX[f"{side}ShoulderPitch"]
        pitch = [angles[slot] for angles in found]
        assert min(pitch) == pytest.approx(
            max(hanging()[slot] - P.backward_angle, body.joints[f"{side}ShoulderPitch"].lower)
        )
        steps = [b - a for a, b in itertools.pairwise(pitch)]
        assert min(steps) >= -P.backward_rate * DT - 1e-9 and max(steps) <= P.return_rate * DT + 1e-9
        assert pitch.index(min(pitch)) * DT == pytest.approx(P.backward_angle / P.backward_rate, abs=0.03)
        assert pitch[-1] == pytest.approx(hanging()[slot])


def test_a_capture_step_ahead_leaves_the_arms():
    assert moved(load_body("nao-v6"), [("L", 0.0)] * 60, capture_step(0.1))[-1] == hanging()
