"""Steps out of a push from a stand: the closed form of the inverted pendulum, and where the feet go."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import pytest

from bridge.body import load_body
from bridge.body.kinematics import CentreOfMass, FloatingBase
from bridge.body.quantities import GRAVITY
from bridge.body.sole import foot_centre
from walker.gaits import GaitCommand, gait_parameters, make_gait, standing_plan
from walker.gaits.plan import CaptureStep, Feedback, Foothold
from walker.gaits.pose import PoseMaker
from walker.mechanisms.capture_step import CaptureEstimator, CaptureParameters

BODY = load_body("nao-v6")
P = gait_parameters("omni")
OMEGA = math.sqrt(GRAVITY / P.z)
TOE, HEEL = (max(x for x, _ in BODY.foot.sole), min(x for x, _ in BODY.foot.sole))
STAND = standing_plan(make_gait("omni", P, BODY))
ANGLES = PoseMaker(BODY, STAND).unlimited_angles(STAND)
WEIGHT = 50.0


def tips(pitch, rate, load=WEIGHT):
    """What a robot that is turned as a whole by `pitch` (rad) and turns at `rate` (rad/s) is taken for."""
    estimator = CaptureEstimator(CaptureParameters(), FloatingBase(BODY))
    return estimator.update(ANGLES, (0.0, pitch), (0.0, rate, 0.0), load, STAND, 0.01)


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
    latency = CaptureParameters().latency
    beyond = step * lever / OMEGA * math.exp(OMEGA * latency)
    assert found.xi == pytest.approx((edge + beyond, 0.0), abs=1e-3)
    assert found.com == pytest.approx((at + latency * (rate + step) * lever, 0.0), abs=1e-3)
    msgspec.msgpack.encode(
        found
    )  # the plan that follows goes out as telemetry, which takes no number of NumPy's


@pytest.mark.parametrize("capture", [None, "R"])
def test_no_capture_step_follows_a_step_of_the_walk_before_its_foot_has_come_to_rest(capture):
    """After a capture step another one may follow at once."""
    estimator = CaptureEstimator(CaptureParameters(), FloatingBase(BODY))
    swing = replace(STAND, phase="SSL", support="L", capture=capture)
    landed = replace(STAND, phase="stop", capture=capture)
    found = [
        estimator.update(ANGLES, (0.0, -0.2), (0.0, -1.0, 0.0), WEIGHT, plan, 0.01) is not None
        for plan in [swing, *[landed] * 20]
    ]
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
    xi = edge + beyond * math.exp(OMEGA * P.T_capture)
    assert foot.x + HEEL < xi < foot.x + TOE
    inset = P.backward_capture_inset if edge == HEEL else 0.0
    assert abs(landed.left.y - landed.right.y) == pytest.approx(P.l_FA - inset, abs=0.02)
    highest = max(max(plan.left.z, plan.right.z) for plan in plans if plan.step == 0)
    assert highest == pytest.approx(P.backward_capture_lift if edge == HEEL else P.l_lift, rel=0.05)
    turned = Foothold(0.3, -0.2, 2.5)  # where the walk began does not matter
    backward = [
        plan.moved(turned).captures_backward
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
