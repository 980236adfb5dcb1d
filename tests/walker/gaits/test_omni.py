"""The omnidirectional gait: closed forms of the pendulum, geometry of the footholds, its limits."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import linprog

from bridge.body import BODIES, load_body
from bridge.body.quantities import GRAVITY
from bridge.body.sole import sole_hull
from bridge.planar import Pose2D
from walker.gaits import GaitCommand, dry_walk, gait_parameters, make_gait
from walker.gaits.catalogue import check_walkable
from walker.gaits.omni.footholds import (
    bounded_capture_point,
    nominal_foothold,
    rate_limited_velocity,
    transfer_weight,
)
from walker.gaits.plan import OTHER_SIDE, Feedback

DT = 0.01
P = gait_parameters("omni")
BODY = load_body("nao-v3")
velocity = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.3, 0.3), st.floats(-3.0, 3.0))


def walk(command, steps=12, **changes):
    gait = make_gait("omni", gait_parameters("omni", changes), BODY)
    state = gait.initial()
    plans = []
    for _ in range(3000):
        asked = GaitCommand(walk=not plans or plans[-1].step < steps, velocity=command)
        plan, state = gait.step(state, DT, asked)
        plans.append(plan)
        if plan.phase == "stand":
            return plans
    pytest.fail("the walk does not end")


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), min_size=2, max_size=6))
@settings(max_examples=20)
def test_bounded_capture_point_is_the_integral_over_the_zmp_to_come(zmps):
    omega, T, T_DSP = 6.1, 0.25, 0.05

    def zmp(t, axis):
        i = int(t / T)
        if i + 1 >= len(zmps):
            return zmps[-1][axis]
        share = min((t - i * T) / T_DSP, 1.0)
        return zmps[i][axis] + share * (zmps[i + 1][axis] - zmps[i][axis])

    found = bounded_capture_point(omega, T, transfer_weight(omega, T_DSP), zmps)
    for axis in (0, 1):
        end = (len(zmps) - 1) * T
        breaks = sorted({b for i in range(len(zmps)) for b in (i * T, i * T + T_DSP) if 0.0 < b < end})
        head, _ = quad(lambda t, a=axis: omega * math.exp(-omega * t) * zmp(t, a), 0.0, end, points=breaks)
        tail = math.exp(-omega * end) * zmps[-1][axis]
        assert found[axis] == pytest.approx(head + tail, abs=1e-7)


def test_offset_of_a_straight_walk_is_the_published_closed_form():
    """Khadiv et al. (T-RO 2020): b_x = L / (e^wT - 1), b_y = w / (1 + e^wT) without double support."""
    omega, T, L, w = 6.1, 0.25, 0.06, 0.1
    zmps = [(i * L, (-1) ** i * w / 2) for i in range(40)]
    x, y = bounded_capture_point(omega, T, 0.0, zmps)
    growth = math.exp(omega * T)
    assert x - zmps[1][0] == pytest.approx(L / (growth - 1.0), rel=1e-9)
    assert y - zmps[1][1] == pytest.approx(w / (1.0 + growth), rel=1e-9)


@pytest.mark.parametrize("command", [(0.2, 0.0, 0.0), (-0.15, 0.0, 0.0), (0.0, 0.1, 0.0), (0.1, 0.05, 0.5)])
def test_centre_of_mass_obeys_the_pendulum(command):
    """x'' = g / z (x - p): second difference of the plan, where the ZMP is at rest for three cycles."""
    plans = walk(command)
    com, zmp = (np.array([getattr(p, name) for p in plans]) for name in ("com", "zmp"))
    acceleration = (com[2:] - 2.0 * com[1:-1] + com[:-2]) / DT**2
    rests = (np.abs(zmp[2:] - zmp[1:-1]) + np.abs(zmp[1:-1] - zmp[:-2])).max(axis=1) < 1e-12
    steps = np.array([p.phase in ("SSL", "SSR") for p in plans])[1:-1]
    inner = rests & steps
    expected = GRAVITY / P.z * (com - zmp)[1:-1]
    assert inner.sum() > 100
    assert acceleration[inner] == pytest.approx(expected[inner], abs=0.01)


@pytest.mark.parametrize("command", [(0.2, 0.0, 0.0), (-0.15, 0.0, 0.0), (0.0, -0.1, 0.0), (0.1, 0.05, 0.8)])
def test_walk_begins_and_ends_in_a_stand_without_jumps(command):
    plans = walk(command)
    first, last = plans[0], plans[-1]
    assert first.phase == "start"
    assert last.left.z == last.right.z == 0.0
    assert last.left.yaw == pytest.approx(last.right.yaw, abs=1e-9)
    apart = Pose2D(last.right.x, last.right.y, last.right.yaw).local(last.left.x, last.left.y)
    assert apart == pytest.approx((0.0, P.l_FA), abs=1e-9)
    middle = last.middle.point(P.zmp_x, 0.0)
    assert last.com == pytest.approx(middle, abs=2e-3)
    for a, b in itertools.pairwise(plans):
        assert math.dist(a.com, b.com) < 0.6 * DT
        for foot in ("left", "right"):
            u, v = getattr(a, foot), getattr(b, foot)
            assert math.dist((u.x, u.y, u.z), (v.x, v.y, v.z)) < 2.0 * DT


@pytest.mark.parametrize("command", [(0.1, 0.0, 0.0), (-0.1, 0.0, 0.0), (0.0, 0.12, 0.0), (0.05, -0.1, 0.8)])
@pytest.mark.parametrize("steps", [9, 10])
def test_plan_ends_where_it_said(command, steps):
    """The feet close at once, or after one more step on the spot."""
    gait = make_gait("omni", P, BODY)
    state = gait.initial()
    for _ in range(1000):
        plan, state = gait.step(state, DT, GaitCommand(walk=True, velocity=command))
        if plan.step == steps - 1 and plan.stop_poses:
            break
    assert len(plan.stop_poses) == 2
    for more, end in enumerate(plan.stop_poses):
        now, then = plan, state
        for _ in range(300):
            asked = GaitCommand(walk=now.step + 1 < steps + more, velocity=(0.0, 0.0, 0.0))
            now, then = gait.step(then, DT, asked)
        assert now.phase == "stand"
        assert now.middle == pytest.approx(end, abs=1e-3)


def test_plan_ends_where_it_said_after_feedback_turned_it():
    gait = make_gait("omni", P, BODY)
    state = gait.initial()
    for _ in range(1000):
        command = GaitCommand(walk=True, velocity=(0.0, 0.0, 0.8), feedback=Feedback(heading=-0.3))
        straight, _ = gait.step(state, DT, command)
        turned, _ = gait.step(state._replace(heading_correction=0.3), DT, command)
        if state.step == 6 and turned.stop_poses:
            break
        _, state = gait.step(state, DT, GaitCommand(walk=True, velocity=(0.0, 0.0, 0.8)))
    assert turned.stop_poses == straight.stop_poses


@pytest.mark.parametrize(
    "command", [(0.2, 0.0, 0.0), (-0.15, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, -0.1, 0.0), (0.0, 0.0, 1.0)]
)
def test_plan_has_the_commanded_velocity(command):
    """Over whole double steps, once the command is reached: place and heading between the feet."""
    plans = walk(command, steps=24)
    landed = [next(p for p in plans if p.step == k) for k in (12, 20)]
    a, b = (p.middle for p in landed)
    time = 8 * P.T
    way = a.local(b.x, b.y)
    assert b.yaw - a.yaw == pytest.approx(command[2] * time, abs=0.02)
    if command[2] == 0.0:
        assert way == pytest.approx((command[0] * time, command[1] * time), abs=0.01)
    else:
        assert math.hypot(*way) < 0.04


@given(velocity)
@settings(max_examples=200)
def test_clipped_command_is_inside_the_limits_and_points_the_same_way(command):
    x, y, yaw = P.clipped(command)
    ahead = P.max_velocity[0] if x > 0.0 else P.max_backward
    norm = math.hypot(x / ahead, y / P.max_velocity[1], yaw / P.max_velocity[2])
    assert norm <= 1.0 + 1e-9
    assert np.cross((x, y, yaw), command) == pytest.approx(np.zeros(3), abs=1e-9)
    if norm < 1.0 - 1e-6:
        assert (x, y, yaw) == command


@given(velocity, velocity)
def test_velocity_changes_no_faster_than_the_limits(now, wanted):
    then = rate_limited_velocity(P, now, wanted)
    bounds = zip(P.max_acceleration, P.max_deceleration, strict=True)
    for before, after, goal, (up, down) in zip(now, then, wanted, bounds, strict=True):
        assert abs(after) - abs(before) <= up * P.T + 2e-9
        assert abs(before) - abs(after) <= down * P.T + 2e-9
        assert before * after >= 0.0
        assert abs(goal - after) <= abs(goal - before)


def _overlap(a, b):
    """Whether two convex polygons share a point: feasibility of a common convex combination."""
    n, m = len(a), len(b)
    equal = np.block([[a.T, -b.T], [np.ones(n), np.zeros(m)], [np.zeros(n), np.ones(m)]])
    return linprog(np.zeros(n + m), A_eq=equal, b_eq=[0.0, 0.0, 1.0, 1.0], bounds=(0, None)).status == 0


@given(velocity, st.sampled_from("LR"))
@settings(max_examples=100)
def test_feet_never_tread_on_each_other(command, side):
    """The soles' outlines of a foothold and the next one, at any velocity that is allowed."""
    inside = P.clipped(command)
    stance = Pose2D()
    landing = nominal_foothold(P, stance, side, inside)
    soles = []
    for foot, s in ((stance, OTHER_SIDE[side]), (landing, side)):
        soles.append(np.array([foot.point(x, y) for x, y in sole_hull(BODY, s)]))
    assert not _overlap(*soles)


@pytest.mark.parametrize("name", BODIES)
def test_every_body_can_walk_to_all_its_limits(name):
    body = load_body(name)
    x, y, yaw = P.max_velocity
    for v in ((x, 0, 0), (-P.max_backward, 0, 0), (0, y, 0), (0, -y, 0), (0, 0, yaw), (0, 0, -yaw)):
        parameters = gait_parameters("omni", dict(zip(("v_x", "v_y", "v_yaw"), map(float, v), strict=True)))
        check_walkable(body, make_gait("omni", parameters, body))


@pytest.mark.parametrize("steps", [2, 3, 5, 8, 20])
def test_bounded_walk_makes_its_steps_and_no_more(steps):
    for speed in (0.2, 0.0):
        gait = make_gait("omni", gait_parameters("omni", {"v_x": speed}), BODY)
        plans = [plan for plan, _ in dry_walk(gait, DT, steps)]
        assert plans[-1].phase == "stand"
        assert plans[-1].step == steps


@pytest.mark.parametrize("steps", [8, 9])
@pytest.mark.parametrize(
    "command",
    [(0.1, 0.0, 0.0), (0.4, 0.0, 0.0), (-0.25, 0.0, 0.0), (0.0, 0.15, 0.0), (0.0, -0.25, 0.0), (0.1, 0.1, 0.5)],
)
def test_zmp_of_the_end_of_a_walk_is_between_the_feet(command, steps):
    """A ZMP outside the support polygon cannot be had: the robot tips over the foot there."""
    gait = make_gait("omni", P, BODY)
    state, plans = gait.initial(), []
    for _ in range(round(6.0 / DT)):
        plan, state = gait.step(state, DT, GaitCommand(walk=state.step < steps, velocity=command))
        plans.append(plan)
    assert plans[-1].phase == "stand"
    ends = [plan.middle.local(*plan.zmp) for plan in plans if plan.phase == "stop"]
    assert max(abs(left) for _, left in ends) < 0.5 * P.l_FA + P.zmp_y + 0.005
    assert max(abs(ahead - P.zmp_x) for ahead, _ in ends) < 0.04


def test_a_walk_ends_though_feedback_corrects_its_velocity():
    """As on a slope, where the feet otherwise would always need another foothold than the one side by side."""
    gait = make_gait("omni", P, BODY)
    state, feedback = gait.initial(), Feedback(velocity=(0.08, 0.08))
    for _ in range(round(6.0 / DT)):
        _, state = gait.step(
            state, DT, GaitCommand(state.step < 8, velocity=(0.1, 0.0, 0.0), feedback=feedback)
        )
    assert state.phase == "stand" and state.step <= 11


@pytest.mark.parametrize("turn", [0.0, 0.5, 1.0])
def test_foothold_follows_the_capture_point_and_the_walk_goes_on_from_there(turn):
    """A deviation that grows like the pendulum moves the foothold by its share; then the walk is as before.

    The share goes from `foothold_gain` straight ahead to `turning_foothold_gain` in the fastest turn.
    """
    gain = (1.0 - turn) * P.foothold_gain[0] + turn * P.turning_foothold_gain[0]
    velocity = (0.0, 0.0, turn * P.max_velocity[2]) if turn else (0.1, 0.0, 0.0)
    gait, calm = make_gait("omni", P.with_velocity(velocity), BODY), walk(velocity, 16)
    omega = math.sqrt(GRAVITY / P.z)
    state, plans = gait.initial(), []
    for before in calm:
        off = 0.0
        if before.step == 8:  # as it grows in this step to 0.03 m at its end
            off = 0.03 * math.exp(-omega * (1.0 - before.progress) * P.T)
        yaw = before.foot(before.support).yaw if before.support != "both" else 0.0
        asked = GaitCommand(
            not plans or plans[-1].step < 16,
            velocity,
            feedback=Feedback((off * math.cos(yaw), off * math.sin(yaw))),
        )
        plan, state = gait.step(state, DT, asked)
        plans.append(plan)
    last = max(k for k, p in enumerate(plans) if p.step == 8)
    side = "R" if plans[last].support == "L" else "L"
    moved = math.dist(plans[last].foot(side)[:2], calm[last].foot(side)[:2])
    assert 0.5 * gain * 0.03 < moved < gain * 0.03
    for a, b in itertools.pairwise(plans):
        assert math.dist(a.com, b.com) < 0.6 * DT
    a, b = plans[-1].middle, calm[-1].middle
    end = math.dist((a.x, a.y), (b.x, b.y))
    assert end == pytest.approx(moved, abs=4e-3)
