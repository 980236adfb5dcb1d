"""Deviation from the plan: a robot that carries the plan out has none, one that is displaced has that."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import LEG_SLOTS
from bridge.body.kinematics import CentreOfMass, FloatingBase, foot_in_torso
from tests.states import rigid_state
from walker.gaits import dry_walk, gait_parameters, make_gait, standing_plan
from walker.gaits.pose import PoseMaker
from walker.mechanisms.foothold_feedback import DeviationEstimator, DeviationParameters

BODY = load_body("nao-v3")
DT = 0.01
LATE = 4
"""Cycles of the latency of 0.04 s."""


SHIPPED = DeviationParameters()
SLOW = DeviationParameters(first_mean_gain=(0.05, 0.05))
"""The mean is learnt in the first steps as later."""


def follow(velocity, ahead=None, cycles=960, parameters=SHIPPED):
    """Feedback over a walk whose encoders show the plan of a latency ago, moved by `ahead(cycle)`, m."""
    names = dict(zip(("v_x", "v_y", "v_yaw"), velocity, strict=True))
    gait = make_gait("omni", gait_parameters("omni", names), BODY)
    pose = PoseMaker(BODY, standing_plan(gait))
    estimator = DeviationEstimator(parameters, FloatingBase(BODY), DT, 0.04, deviation=True, placement=True)
    plans, found = [], []
    for k, (plan, _) in enumerate(itertools.islice(dry_walk(gait, DT), cycles)):
        plans.append(plan)
        then = plans[max(k - LATE, 0)]
        x = ahead(k) if ahead else 0.0
        angles = pose.unlimited_angles(replace(then, com=(then.com[0] + x, then.com[1])))
        found.append((plan, estimator.update(rigid_state(BODY, angles).com, plan, DT)))
    return found


@pytest.mark.parametrize("velocity", [(0.2, 0.0, 0.0), (0.0, 0.1, 0.0)])
def test_a_robot_that_carries_out_its_plan_has_little_deviation(velocity):
    """Legs move the centre of mass by some millimetres in each step alike; the mean takes that out."""
    feedback = [f for plan, f in follow(velocity) if 24 <= plan.step < 38]
    assert np.abs([f.deviation for f in feedback]).max() < 0.012
    assert abs(feedback[-1].foothold_bias) < 0.006  # a foot late by the latency is 4 mm behind


@pytest.mark.parametrize(("begin", "unlearnt"), [(120, 0.015), (620, 0.0)])
def test_a_centre_of_mass_that_runs_ahead_is_predicted_by_the_pendulum(begin, unlearnt):
    """x = a e^(w t) has the capture point 2 x; after the latency it is e^(w d) times as far. Cycle 120 is in
    the fourth step: a worn robot falls back in its first steps unless they answer. There what a nominal robot's
    joints yield, 15 mm, counts as none."""
    gait = make_gait("omni", gait_parameters("omni", {"v_x": 0.0}), BODY)
    pose, stand = PoseMaker(BODY, standing_plan(gait)), standing_plan(gait)
    there, here = (pose.unlimited_angles(replace(stand, com=(stand.com[0] + x, 0.0))) for x in (0.01, 0.0))
    slots = LEG_SLOTS["L"]
    com = CentreOfMass(BODY)
    at = [com(q)[0] - foot_in_torso(BODY, "L", [q[slot] for slot in slots])[0, 3] for q in (there, here)]
    share = (at[0] - at[1]) / 0.01  # the feet stay behind, and their mass with them
    omega = math.sqrt(9.81 / gait_parameters("omni").z)

    def ahead(k):
        return 0.004 * math.exp(omega * (k - begin) * DT) if k >= begin else 0.0

    k = begin + 18
    pushed, calm = (follow((0.0, 0.0, 0.0), way, k + 1, SLOW) for way in (ahead, None))
    found = pushed[k][1].deviation[0] - calm[k][1].deviation[0]
    assert pushed[k][0].support != "both"
    capture_point = share * 2.0 * ahead(k) * math.exp(omega * 0.04)
    assert found == pytest.approx(capture_point - unlearnt, abs=0.25 * capture_point)


def test_a_constant_offset_is_learnt_in_the_first_steps():
    """Nominal joints yield by some 20 mm in every step alike; what is taken for a deviation makes it faster."""
    after = [f.deviation[0] for plan, f in follow((0.0, 0.0, 0.0), lambda k: 0.03) if 6 <= plan.step < 10]
    slowly = [
        f.deviation[0] for plan, f in follow((0.0, 0.0, 0.0), lambda k: 0.03, 960, SLOW) if 6 <= plan.step < 10
    ]
    assert np.abs(after).max() < 0.005 < np.abs(slowly).max()
