"""The arm that goes out while a robot tips over its stance foot."""

from __future__ import annotations

import itertools

import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, N_JOINTS
from walker.model.arms import ARMS
from walker.model.com import CentreOfMass
from walker.stabilization.arm_counterweight import ArmCounterweight, ArmCounterweightParameters

DT = 0.01
P = ArmCounterweightParameters()
OUTWARD = {"L": 1.0, "R": -1.0}
"""Sign of a ShoulderRoll that lifts the arm to its own side (data sheet of the NAO: positive to the left)."""


def hanging():
    """25 angles with the arms of a walk."""
    angles = [0.0] * N_JOINTS
    for joint, angle in ARMS.items():
        angles[INDEX[joint]] = angle
    return angles


def moved(body, signals):
    """Angles in each cycle.

    Args:
        body: data sheet.
        signals: support and tipping, m, by cycle.
    """
    arm, found = ArmCounterweight(P, body), []
    for support, tipping in signals:
        angles = hanging()
        arm.update(angles, support, tipping, DT)
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
    ArmCounterweight(ArmCounterweightParameters(max_rate=500.0), body).update(angles, "L", 0.3, DT)
    assert angles[INDEX["RShoulderRoll"]] == body.joints["RShoulderRoll"].lower
