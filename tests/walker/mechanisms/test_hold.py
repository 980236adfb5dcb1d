"""Hold of heading and velocity: a robot whose feet spin and slip alike in every step keeps the command."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge.body import load_body
from bridge.planar import Pose2D
from tests.loops import repeat_while
from walker.gaits import GaitCommand, gait_parameters, make_gait
from walker.gaits.order import WalkOrder, WalkPlanner
from walker.gaits.plan import Feedback
from walker.mechanisms.hold import HeadingError, VelocityHold, VelocityHoldParameters

BODY = load_body("nao-v6")
P = gait_parameters("omni")
DT = 0.01
LATENCY = 0.04


def walked(turn, spin, steps=40, *, gain=P.heading_gain, began=3.0):
    """True heading less the commanded one, rad, at the end of each step; both feet share a turn evenly.

    Args:
        turn: commanded, rad/s.
        spin: of the standing foot on the floor in each step, rad.
        steps: number of steps.
        gain: of the gait.
        began: heading by the odometry at the first step, rad.
    """
    gait = make_gait("omni", gait_parameters("omni", {"heading_gain": gain, "turn_share": 0.5}), BODY)
    error, state = HeadingError(LATENCY, DT), gait.initial()
    plans, ends, feedback = [], [], Feedback()
    for _ in repeat_while(lambda: len(ends) < steps):
        plan, state = gait.step(state, DT, GaitCommand(walk=True, velocity=(0.0, 0.0, turn), feedback=feedback))
        if plans and plan.step > plans[-1].step:
            ends.append(plan.middle.yaw + plan.step * spin - turn * P.T * plan.step)
        plans.append(plan)
        then = plans[max(len(plans) - 1 - round(LATENCY / DT), 0)]
        there = began + then.middle.yaw + then.step * spin
        feedback = Feedback(heading=error.update(math.remainder(there, math.tau), plan))
    return ends


@pytest.mark.parametrize("turn", [0.0, 0.6, -0.6])
def test_spin_is_taken_back_and_leaves_a_steady_error(turn):
    """e' = e + s - K (e - s), as the last spin is seen a step later, rests at s / K + s; without K it grows.

    The mean of the soles is half a step's correction, s / 2, behind.
    """
    spin = math.radians(1.0)
    held, calm = (walked(turn, each)[-8:] for each in (spin, 0.0))
    assert (sum(held) - sum(calm)) / 8 == pytest.approx(spin / P.heading_gain + 1.5 * spin, rel=0.01)
    free = walked(turn, spin, gain=0.0)
    assert free[-1] - free[-11] == pytest.approx(10 * spin, rel=1e-6)


@pytest.mark.parametrize("spin_deg", [1.0, -1.0])
def test_spin_is_taken_back_when_its_sum_passes_half_and_full_turns(spin_deg):
    """The spins of 400 steps make more than a full circle; the heading rests where that of 40 steps does."""
    spin = math.radians(spin_deg)
    early, late = (sum(walked(0.0, spin, steps)[-8:]) / 8 for steps in (40, 400))
    assert late == pytest.approx(early, rel=0.01)


def test_the_fastest_turn_is_not_exceeded():
    fastest = P.max_velocity[2]
    heading, free = walked(fastest, -0.05), walked(fastest, -0.05, gain=0.0)
    assert heading == pytest.approx(free, abs=1e-9)


HOLD = VelocityHoldParameters()


def slipped(command, slip, steps=60, *, hold=HOLD):
    """Mean velocity of the last eight steps in the heading of the feet, m/s.

    Args:
        command: m/s, m/s, rad/s.
        slip: way of both feet on the floor in each step, ahead and to the left of the feet, m.
        steps: number of steps.
        hold: parameters.
    """
    gait = make_gait("omni", P, BODY)
    learner, state, feedback = VelocityHold(hold), gait.initial(), Feedback()
    slipped, last, step = (0.0, 0.0), Pose2D(), 0
    way = [0.0, 0.0]
    for _ in range(round((steps + 10) * P.T / DT)):
        plan, state = gait.step(state, DT, GaitCommand(walk=True, velocity=command, feedback=feedback))
        if step == steps:
            break
        middle, counts = plan.middle, step >= steps - 8
        if plan.step > step:
            step = plan.step
            slipped = Pose2D(*slipped, middle.yaw).point(*slip)
        here = Pose2D(middle.x + slipped[0], middle.y + slipped[1], middle.yaw)
        if counts:
            for axis, moved in enumerate(last._replace(yaw=0.5 * (last.yaw + here.yaw)).local(here.x, here.y)):
                way[axis] += moved
        feedback = Feedback(velocity=learner.update(here, plan, DT))
        last = here
    return way[0] / (8 * P.T), way[1] / (8 * P.T)


@pytest.mark.parametrize("command", [(0.2, 0.0, 0.0), (0.0, 0.1, 0.0), (0.1, -0.05, -0.4), (0.0, 0.0, 1.0)])
@pytest.mark.parametrize("slip", [(0.0, 0.0), (0.004, 0.0), (-0.003, 0.003)])
def test_slip_is_made_up_for(command, slip):
    assert slipped(command, slip) == pytest.approx(command[:2], abs=0.003)


def test_the_correction_is_bounded():
    bound = HOLD.max_correction
    assert slipped((0.1, 0.0, 0.0), (0.02, 0.0))[0] == pytest.approx(0.1 + 0.02 / P.T - bound, abs=0.003)


def test_the_fastest_velocity_is_not_exceeded():
    fastest = P.max_velocity[0]
    slip = 0.002
    assert slipped((fastest, 0.0, 0.0), (-slip, 0.0))[0] == pytest.approx(fastest - slip / P.T, rel=0.01)


def test_a_stand_forgets_it():
    gait, learner = make_gait("omni", P, BODY), VelocityHold(HOLD)
    state = gait.initial()
    for n in range(400):
        plan, state = gait.step(state, DT, GaitCommand(walk=True, velocity=(0.1, 0.0, 0.0)))
        found = learner.update(Pose2D(0.2 * n * DT), plan, DT)
    assert found[0] < -0.01
    standing, _ = gait.step(gait.initial(), DT, GaitCommand(walk=False))
    assert learner.update(Pose2D(), standing, DT) == (0.0, 0.0)


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
