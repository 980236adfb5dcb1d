"""Velocity hold: a robot whose feet slip by the same way in every step keeps the commanded velocity."""

from __future__ import annotations

import numpy as np
import pytest

from bridge.body import load_body
from walker.gaits import GaitCommand, gait_parameters, make_gait
from walker.gaits.order import WalkOrder, WalkPlanner
from walker.gaits.plan import Feedback, Foothold
from walker.mechanisms.hold import VelocityHold, VelocityHoldParameters

BODY = load_body("nao-v6")
P = gait_parameters("omni")
DT = 0.01
HOLD = VelocityHoldParameters()


def walked(command, slip, steps=60, *, hold=HOLD):
    """Mean velocity of the last eight steps in the heading of the feet, m/s.

    Args:
        command: m/s, m/s, rad/s.
        slip: way of both feet on the floor in each step, ahead and to the left of the feet, m.
        steps: number of steps.
        hold: parameters.
    """
    gait = make_gait("omni", P, BODY)
    learner, state, feedback = VelocityHold(hold), gait.initial(), Feedback()
    slipped, last, step = (0.0, 0.0), Foothold(), 0
    way = [0.0, 0.0]
    for _ in range(round((steps + 10) * P.T / DT)):
        plan, state = gait.step(state, DT, GaitCommand(walk=True, velocity=command, feedback=feedback))
        if step == steps:
            break
        middle, counts = plan.middle, step >= steps - 8
        if plan.step > step:
            step = plan.step
            slipped = Foothold(*slipped, middle.yaw).point(*slip)
        here = Foothold(middle.x + slipped[0], middle.y + slipped[1], middle.yaw)
        if counts:
            for axis, moved in enumerate(last._replace(yaw=0.5 * (last.yaw + here.yaw)).local(here.x, here.y)):
                way[axis] += moved
        feedback = Feedback(velocity=learner.update(here, plan, DT))
        last = here
    return way[0] / (8 * P.T), way[1] / (8 * P.T)


@pytest.mark.parametrize("command", [(0.2, 0.0, 0.0), (0.0, 0.1, 0.0), (0.1, -0.05, -0.4), (0.0, 0.0, 1.0)])
@pytest.mark.parametrize("slip", [(0.0, 0.0), (0.004, 0.0), (-0.003, 0.003)])
def test_slip_is_made_up_for(command, slip):
    assert walked(command, slip) == pytest.approx(command[:2], abs=0.003)


def test_without_it_slip_is_all_there():
    off = VelocityHoldParameters(gain=0.0)
    assert walked((0.2, 0.0, 0.0), (0.004, 0.0), hold=off)[0] == pytest.approx(0.2 + 0.004 / P.T, rel=0.01)


def test_the_correction_is_bounded():
    bound = HOLD.max_correction
    assert walked((0.1, 0.0, 0.0), (0.02, 0.0))[0] == pytest.approx(0.1 + 0.02 / P.T - bound, abs=0.003)


def test_the_fastest_velocity_is_not_exceeded():
    fastest = P.max_velocity[0]
    slip = 0.002
    assert walked((fastest, 0.0, 0.0), (-slip, 0.0))[0] == pytest.approx(fastest - slip / P.T, rel=0.01)


def test_a_stand_forgets_it():
    gait, learner = make_gait("omni", P, BODY), VelocityHold(HOLD)
    state = gait.initial()
    for n in range(400):
        plan, state = gait.step(state, DT, GaitCommand(walk=True, velocity=(0.1, 0.0, 0.0)))
        found = learner.update(Foothold(0.2 * n * DT), plan, DT)
    assert found[0] < -0.01
    standing, _ = gait.step(gait.initial(), DT, GaitCommand(walk=False))
    assert learner.update(Foothold(), standing, DT) == (0.0, 0.0)


@pytest.mark.parametrize(("target", "same"), [((0.5, 0.0, 0.0), True), (None, False)])
def test_on_the_way_to_a_place_the_steering_alone_acts(target, same):
    plans = []
    for off in ((0.0, 0.0), HOLD.max_correction * np.ones(2)):
        planner = WalkPlanner(make_gait("omni", P, BODY), WalkOrder(target=target), velocity=(0.1, 0.0, 0.0))
        for _ in range(200):
            plan = planner.step(DT, walk=True, feedback=Feedback(velocity=tuple(off)))
        plans.append(plan)
    assert (plans[0] == plans[1]) is same


def test_a_robot_that_lags_while_it_speeds_up_teaches_nothing():
    """The command rises for five steps; a middle that is half a step behind then is no error to make up for."""
    gait = make_gait("omni", P, BODY)
    learner, state, ways, learnt = VelocityHold(HOLD), gait.initial(), [], []
    for _ in range(round(2.2 / DT)):
        plan, state = gait.step(state, DT, GaitCommand(walk=True, velocity=(0.25, 0.0, 0.0)))
        ways.append(plan.middle)
        learnt.append(learner.update(ways[max(len(ways) - 1 - round(0.5 * P.T / DT), 0)], plan, DT)[0])
        if plan.pendulum.velocity[0] < 0.25:
            assert learnt[-1] == 0.0
    assert max(learnt) < 0.01  # 0.03 where the rise is learnt
