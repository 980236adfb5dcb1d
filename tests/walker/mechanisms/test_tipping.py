"""A robot that tips over its stance foot: when a step lasts longer."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from bridge.body import load_body
from nao_hil.runs.config import RunConfig
from nao_hil.runs.events import StridePush
from nao_hil.runs.walk import Walk, walk
from walker.gaits import GaitCommand, gait_parameters, make_gait
from walker.gaits.gait import standing_plan
from walker.gaits.plan import SIGN, Feedback
from walker.mechanisms.tipping import (
    TippingDetector,
    TippingParameters,
)

DT = 0.01
P = gait_parameters("omni")
BODY = load_body("nao-v6")
TIPPING = TippingParameters()


def watched(outward, *, support="L", yaw=0.0, along=0.0):
    """Answers of the detector to a deviation in each cycle of a step that goes on as long as it is held.

    Args:
        outward: m, by cycle.
        support: the stance foot.
        yaw: its heading, rad.
        along: deviation along the foot, m.
    """
    detector = TippingDetector(TIPPING)
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


def test_a_robot_that_does_not_come_back_is_not_waited_for():
    held = [each.extend_step for each in watched([0.1] * 300)]
    cycles = round((P.T + TIPPING.max_hold) / DT)
    assert held[cycles - 3] and not any(held[cycles + 3 : cycles + 4])


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


def pushed(seed):
    """Whether a V6 stands that is pushed to the left late in the swing of its left foot."""
    config = RunConfig(
        robot="nao-v6",
        wear="nominal",
        engine="mujoco",
        gait="omni",
        seed=seed,
        steps=0,
        velocity=(0.15, 0.0, 0.0),
    )
    push = StridePush(time=2.0, phase=0.875, impulse=1.5, direction=0.5 * math.pi)
    end = walk(Walk(name="test", config=config, duration=5.5, pushes=(push,), keep_track=False)).end
    return end.survived


def test_a_robot_that_tips_over_the_edge_of_its_foot_comes_back():
    """Three seeds, pushed by 1.5 N s to the left late in the swing of the left foot."""
    assert sum(pushed(seed) for seed in range(302011, 302014)) >= 2
