"""A robot that tips over its stance foot: when a step lasts longer, where swing foot and arm go."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, N_JOINTS
from bridge.body.kinematics import CentreOfMass
from nao_hil.runs.config import RunConfig
from nao_hil.runs.events import StridePush
from nao_hil.runs.walk import Walk, walk
from walker.gaits import GaitCommand, gait_parameters, make_gait
from walker.gaits.gait import standing_plan
from walker.gaits.plan import SIGN, Feedback, SolePose
from walker.gaits.pose import ARMS
from walker.mechanisms.tipping import (
    ArmCounterweight,
    ArmCounterweightParameters,
    TippingDetector,
    TippingParameters,
)

DT = 0.01
P = gait_parameters("omni")
BODY = load_body("nao-v6")
TIPPING = TippingParameters()


def watched(outward, *, support="L", yaw=0.0, along=0.0, hold=True, counterweight=True):
    """Answers of the detector to a deviation in each cycle of a step that goes on as long as it is held.

    Args:
        outward: m, by cycle.
        support: the stance foot.
        yaw: its heading, rad.
        along: deviation along the foot, m.
        hold: switch.
        counterweight: switch.
    """
    detector = TippingDetector(TIPPING, hold=hold, counterweight=counterweight)
    plan, found, t = standing_plan(make_gait("omni", P, BODY)), [], 0.0
    feet = {"left" if support == "L" else "right": plan.left._replace(yaw=yaw)}
    for off in outward:
        stepping = replace(plan, support=support, phase=f"SS{support}", progress=min(t / P.T, 1.0), **feet)
        across = SIGN[support] * off
        c, s = math.cos(yaw), math.sin(yaw)
        deviation = c * along - s * across, s * along + c * across
        found.append(detector.update(Feedback(deviation), stepping, DT))
        t += DT
    return found


@pytest.mark.parametrize("support", ["L", "R"])
@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_a_step_is_prolonged_until_the_capture_point_is_back(support, yaw):
    cycles = round(P.T / DT)
    back = [0.09] * (cycles + 30) + [0.02] * 10 + [-0.01] * 5
    held = [each.extend_step for each in watched(back, support=support, yaw=yaw)]
    assert not any(held[: round(0.8 * cycles)])
    assert all(held[cycles : cycles + 40])
    assert not any(held[cycles + 40 :])


def test_an_undisturbed_step_ends_in_time_and_moves_no_foot():
    for off in (-0.2, 0.0, TIPPING.counterweight_deviation):
        assert not any(each.extend_step or each.counterweight for each in watched([off] * 60))


def test_a_robot_that_does_not_come_back_is_not_waited_for():
    held = [each.extend_step for each in watched([0.1] * 300)]
    cycles = round((P.T + TIPPING.max_hold) / DT)
    assert held[cycles - 3] and not any(held[cycles + 3 : cycles + 4])


def test_the_counterweight_is_that_of_a_robot_that_tips_to_the_side():
    gain, bound = TIPPING.counterweight_gain, TIPPING.counterweight_deviation
    for along, expected in ((0.0, gain * (0.07 - bound)), (0.02, gain * (0.06 - bound)), (-0.08, 0.0)):
        for yaw in (0.0, -1.1):
            found = [each.counterweight for each in watched([0.07] * 25, support="R", yaw=yaw, along=along)]
            rate = TIPPING.counterweight_rate
            assert found == pytest.approx([min(expected, rate * DT * (k + 1)) for k in range(25)])


def test_tipping_is_the_deviation_to_the_outside_less_half_of_that_along_the_foot():
    for support in ("L", "R"):
        for yaw in (0.0, 0.7):
            found = [each.tipping for each in watched([0.07] * 3, support=support, yaw=yaw, along=-0.02)]
            assert found == pytest.approx([0.06] * 3)
    both = TippingDetector(TIPPING, hold=True, counterweight=True)
    assert both.update(Feedback((0.1, 0.1)), standing_plan(make_gait("omni", P, BODY)), DT).tipping == 0.0


def test_each_switch_turns_off_its_own():
    held = watched([0.09] * 60, counterweight=False)
    moved = watched([0.09] * 60, hold=False)
    assert any(each.extend_step for each in held) and not any(each.counterweight for each in held)
    assert any(each.counterweight for each in moved) and not any(each.extend_step for each in moved)


def plans(feedback):
    """Of a walk ahead; `feedback` by plan before."""
    gait = make_gait("omni", P, BODY)
    state, plan = gait.initial(), standing_plan(gait)
    for _ in range(400):
        plan, state = gait.step(state, DT, GaitCommand(True, (0.15, 0.0, 0.0), feedback=feedback(plan)))
        yield plan


def test_a_held_step_rests_at_its_end_and_the_walk_goes_on_from_there():
    cycles = 37
    waits = iter([True] * cycles)

    def held(plan):
        last = plan.step == 8 and plan.progress > 0.9
        return Feedback(extend_step=last and next(waits, False))

    calm, found = list(plans(lambda _: Feedback())), list(plans(held))
    rests = [p for p in found if p.step == 8 and p.progress == 1.0]
    assert len(rests) >= cycles - 3
    for p in rests:
        for foot, first in ((p.left, rests[0].left), (p.right, rests[0].right)):
            assert (foot.x, foot.y, foot.z) == pytest.approx((first.x, first.y, first.z), abs=1e-9)
        assert p.com == pytest.approx(rests[0].com, abs=1e-9)
    for step in (9, 12):
        a, b = (next(p for p in walked if p.step == step) for walked in (calm, found))
        assert (b.left.x, b.right.x, b.left.y, b.right.y) == pytest.approx(
            (a.left.x, a.right.x, a.left.y, a.right.y), abs=5e-3
        )


def test_the_swing_foot_goes_out_by_the_counterweight_and_no_farther_than_the_legs_spread():
    for wished in (0.05, 0.5):
        found = list(plans(lambda p, by=wished: Feedback(counterweight=by if p.step == 8 else 0.0)))
        end = [p for p in found if p.step == 8][-1]
        width = end.left.y - end.right.y
        assert width == pytest.approx(min(P.l_FA + wished, P.max_width), abs=6e-3)


def pushed(seed, switches):
    """Whether a V6 stands that is pushed to the left late in the swing of its left foot."""
    config = RunConfig(
        robot="nao-v6",
        wear="nominal",
        engine="mujoco",
        gait="omni",
        seed=seed,
        steps=0,
        velocity=(0.15, 0.0, 0.0),
        controller={"switches": switches},
    )
    push = StridePush(time=2.0, phase=0.875, impulse=1.5, direction=0.5 * math.pi)
    end = walk(Walk(name="test", config=config, duration=5.5, pushes=(push,), keep_track=False)).end
    return end.survived


def test_a_robot_that_tips_over_the_edge_of_its_foot_comes_back():
    """Three seeds, pushed by 1.5 N s to the left late in the swing of the left foot."""
    assert sum(pushed(seed, {}) for seed in range(302011, 302014)) >= 2


P_ARM = ArmCounterweightParameters()
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
    arm, found = ArmCounterweight(P_ARM, body), []
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
    assert max(rates) <= P_ARM.max_rate * DT + 1e-9
    assert outward(found[-1], side) == pytest.approx(P_ARM.max_angle)
    assert outward(found[-1], support) == 0.0
    com = CentreOfMass(body)
    shift = float(com(found[-1])[1]) - float(com(hanging())[1])
    assert OUTWARD[side] * shift > 0.003
    for slot in set(range(N_JOINTS)) - {INDEX[f"{side}ShoulderRoll"]}:
        assert found[-1][slot] == hanging()[slot]


def test_up_to_the_bound_nothing_moves_and_beyond_it_in_proportion():
    body = load_body("nao-v6")
    assert moved(body, [("L", P_ARM.deviation)] * 30)[-1] == hanging()
    assert outward(moved(body, [("L", P_ARM.deviation + 0.02)] * 30)[-1], "R") == pytest.approx(
        0.02 * P_ARM.gain
    )


@pytest.mark.parametrize("after", ["both", "R", "L"])
def test_the_arm_comes_back_slowly_whatever_foot_stands_then(after):
    found = moved(load_body("nao-v6"), [("L", 0.3)] * 60 + [(after, 0.0)] * 130)
    away = [outward(angles, "R") for angles in found[59:]]
    steps = [a - b for a, b in itertools.pairwise(away)]
    assert max(steps) <= P_ARM.return_rate * DT + 1e-9 and min(steps) >= 0.0
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
    arm, found = ArmCounterweight(P_ARM, body), []
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
            max(hanging()[slot] - P_ARM.backward_angle, body.joints[f"{side}ShoulderPitch"].lower)
        )
        steps = [b - a for a, b in itertools.pairwise(pitch)]
        assert min(steps) >= -P_ARM.backward_rate * DT - 1e-9 and max(steps) <= P_ARM.return_rate * DT + 1e-9
        assert pitch.index(min(pitch)) * DT == pytest.approx(
            P_ARM.backward_angle / P_ARM.backward_rate, abs=0.03
        )
        assert pitch[-1] == pytest.approx(hanging()[slot])


def test_a_capture_step_ahead_leaves_the_arms():
    assert moved(load_body("nao-v6"), [("L", 0.0)] * 60, capture_step(0.1))[-1] == hanging()
