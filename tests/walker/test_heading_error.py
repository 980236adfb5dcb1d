"""Heading hold: a robot whose feet spin by the same angle in every step keeps the commanded turn rate."""

from __future__ import annotations

import math

import pytest

from bridge.body import load_body
from tests.loops import repeat_while
from walker.gaits import GaitCommand, gait_parameters, make_gait
from walker.gaits.plan import Feedback
from walker.mechanisms.hold import HeadingError

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


def test_the_fastest_turn_is_not_exceeded():
    fastest = P.max_velocity[2]
    heading, free = walked(fastest, -0.05), walked(fastest, -0.05, gain=0.0)
    assert heading == pytest.approx(free, abs=1e-9)
