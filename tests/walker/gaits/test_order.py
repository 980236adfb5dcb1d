"""Steering to a target: a point that moves as it is told arrives, and stays within the gait's limits."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bridge.errors import ConfigurationError
from bridge.planar import Pose2D
from walker.gaits import gait_parameters
from walker.gaits.omni.footholds import rate_limited_velocity
from walker.gaits.order import ARRIVAL_ANGLE, ARRIVAL_DISTANCE, Steering, WalkOrder, target_order

P = gait_parameters("omni")
start = st.builds(Pose2D, st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))


def moved(here: Pose2D, velocity, dt: float) -> Pose2D:
    """Along the arc of a constant velocity."""
    x, y, turn = (v * dt for v in velocity)
    middle = Pose2D(here.x, here.y, here.yaw + 0.5 * turn)
    return Pose2D(*middle.point(x, y), here.yaw + turn)


def end(steering: Steering, here: Pose2D, steps: int = 400) -> tuple[Pose2D, int]:
    """Where it arrives: the velocity changes from step to step, within the gait's accelerations."""
    velocity = (0.0, 0.0, 0.0)
    for step in range(steps):
        if steering.arrived(here, here):
            return here, step
        wanted = P.clipped(steering.velocity(here))
        velocity = rate_limited_velocity(P, velocity, wanted)
        here = moved(here, velocity, P.T)
    pytest.fail(f"not there after {steps} steps, but at {here}")


@given(start, st.floats(0.3, 1.0))
@settings(max_examples=60)
def test_it_arrives_from_anywhere(begin, share):
    goal = Pose2D(0.4, -0.1, 1.0)
    there, _ = end(Steering(P, goal, share), begin)
    assert math.dist(there[:2], goal[:2]) <= ARRIVAL_DISTANCE
    assert abs(math.remainder(there.yaw - goal.yaw, math.tau)) <= ARRIVAL_ANGLE


def test_a_walk_that_drifts_more_than_it_may_correct_ends_close_to_its_goal():
    """It passes 1.5 cm beside the goal, and each step moves it on by 5 mm that are not commanded."""
    steering, here = Steering(P, Pose2D(0.05, 0.015), share=0.02), Pose2D()
    for _ in range(60):
        if steering.arrived(here, here):
            break
        x, _, turn = steering.velocity(here)
        here = moved(here, (max(x, -0.005) + 0.02, 0.0, turn), P.T)
    assert steering.arrived(here, here)
    assert math.dist(here[:2], (0.05, 0.015)) < 6.0 * ARRIVAL_DISTANCE


def test_a_long_way_is_walked_at_full_speed_and_the_short_rest_slowly():
    """Far off the speed is the limit's, near the goal that of a brake: v^2 = 2 a s at most."""
    steering = Steering(P, Pose2D(5.0))
    assert steering.velocity(Pose2D())[0] == pytest.approx(P.max_velocity[0])
    for rest in (0.2, 0.1, 0.05):
        assert steering.velocity(Pose2D(5.0 - rest))[0] ** 2 <= 2.0 * P.max_acceleration[0] * rest


def test_a_target_is_for_gaits_of_any_direction_and_as_fast_as_their_velocity():
    order = target_order(WalkOrder(), (1.0, 0.0, 0.0), P.with_velocity((0.15, 0.0, 0.0)))
    assert order.target == (1.0, 0.0, 0.0)
    assert order.share == pytest.approx(0.15 / P.max_velocity[0])
    with pytest.raises(ConfigurationError, match="straight ahead"):
        target_order(WalkOrder(), (1.0, 0.0, 0.0), gait_parameters("dynamic"))
