"""The dynamic gait against the numbers of thesis 3.3.2, the pendulum's equation of motion, and its promises."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bridge.body import BODIES, Body, load_body
from bridge.errors import ConfigurationError
from bridge.types import Array
from walker.gaits import GaitCommand, Plan, dry_walk, gait_parameters, standing_plan
from walker.gaits.thesis.dynamic.gait import DynamicGait
from walker.gaits.thesis.dynamic.step import DynamicParameters, plan_step

G = 9.81
BODY = load_body("nao-v3")


def parameters(**changes: float | str) -> DynamicParameters:
    shipped = gait_parameters("dynamic")
    assert isinstance(shipped, DynamicParameters)
    return msgspec.structs.replace(shipped, **changes)


def walk(gait: DynamicGait, steps: int, dt: float = 0.01) -> Iterator[Plan]:
    return (plan for plan, _ in dry_walk(gait, dt, steps))


def test_the_printed_parameters_give_the_checked_numbers() -> None:
    """Figures 3.6 and 3.7: e_s1 = 0.03, e_su = 0.0051, S_a0 = 0.04, z = 0.23, d_0 = 0.05."""
    plan = plan_step(parameters())
    assert plan.pendulum.nu == pytest.approx(6.5309, abs=5e-5)
    for name, printed in {
        "t_a": 0.22173,
        "V_ya": 0.26254,
        "V_h": 0.29178,
        "V_1": 0.12997,
        "T_DSP": 0.03885,
        "S_b": 0.01134,
        "S_a": 0.04,
        "length": 0.09134,
        "duration": 0.48231,
    }.items():
        assert getattr(plan, name) == pytest.approx(printed, abs=5.1e-6), name
    assert plan.length / plan.duration == pytest.approx(0.189, abs=5e-4)


def test_deceleration_from_C_ends_at_D_in_x_and_y_at_once() -> None:
    """(3.11) from the initial conditions (3.12), by numerical integration of (3.8)."""
    p = parameters()
    plan = plan_step(p)
    start = [-plan.S_a, -p.d_0 + p.e_su, plan.V_h, plan.V_ya]
    way = solve_ivp(
        lambda _, s: [s[2], s[3], G / p.z * s[0], G / p.z * s[1]],
        (0.0, 2.0 * plan.t_a),
        start,
        t_eval=[plan.t_a, 2.0 * plan.t_a],
        rtol=1e-11,
        atol=1e-13,
    )
    assert way.y[:, 0] == pytest.approx([0.0, -p.d_0 + p.e_s1, plan.V_1, 0.0], abs=1e-8)
    assert way.y[:, 1] == pytest.approx([p.S_a0, -p.d_0 + p.e_su, plan.V_h, -plan.V_ya], abs=1e-8)


def test_single_support_obeys_the_pendulum_equation_about_the_planned_zmp() -> None:
    """Central differences of the planned centre of mass against (3.8), and the ZMP rests."""
    gait = DynamicGait(parameters(), BODY)
    h = 1e-4
    plans = list(walk(gait, 4, h))
    checked = 0
    for before, now, after in zip(plans, plans[1:], plans[2:], strict=False):
        if now.support != "both" and before.phase == now.phase == after.phase:
            stance = now.left if now.support == "L" else now.right
            assert now.zmp == pytest.approx((stance.x + BODY.foot.centre[0], stance.y), abs=1e-12)
            for axis in (0, 1):
                acceleration = (before.com[axis] - 2.0 * now.com[axis] + after.com[axis]) / h**2
                assert acceleration == pytest.approx(G / 0.23 * (now.com[axis] - now.zmp[axis]), abs=1e-5)
            checked += 1
    assert checked > 10_000


def test_orbital_energy_is_conserved_in_every_single_support() -> None:
    gait = DynamicGait(parameters(), BODY)
    energies: dict[tuple[str, int], list[tuple[float, float]]] = {}
    for plan, state in dry_walk(gait, 0.01, 6):
        if plan.support != "both":
            energy = tuple(
                m.velocity**2 - G / 0.23 * (m.position - zmp) ** 2
                for m, zmp in zip(gait.com_motion(state), plan.zmp, strict=True)
            )
            energies.setdefault((plan.phase, plan.step), []).append(energy)
    assert len(energies) == 6
    for values in energies.values():
        assert np.ptp(values, axis=0) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("first", ["L", "R"])
def test_position_and_velocity_are_continuous_over_the_whole_walk(first: str) -> None:
    """0.1 ms move the mass, and change its velocity, no further than its speed and acceleration allow."""
    gait = DynamicGait(parameters(first_swing=first), BODY)
    dt, changes = 1e-4, 0
    before, motion = None, gait.com_motion(gait.initial())
    for plan, state in dry_walk(gait, dt, 3):
        now = gait.com_motion(state)
        if before is not None:
            changes += before.phase != plan.phase
            for old, new in zip(motion, now, strict=True):
                mean = 0.5 * (old.velocity + new.velocity)
                assert new.position - old.position == pytest.approx(mean * dt, abs=1e-8)
                allowed = 1.001 * max(abs(old.acceleration), abs(new.acceleration)) * dt + 1e-9
                assert abs(new.velocity - old.velocity) <= allowed
        before, motion = plan, now
    assert changes == 7  # start, SS, DS, SS, DS, SS, stop, stand


def test_phases_meet_exactly_where_they_change() -> None:
    """The closed forms of both phases at the very instant of the change, to 1e-9."""
    p = parameters()
    gait = DynamicGait(p, BODY)
    plan = gait.plan
    durations = [p.T_start, plan.t_a, plan.T_DSP, 2 * plan.t_a, plan.T_DSP, 2 * plan.t_a, plan.T_DSP, plan.t_a]
    gap = 1e-11
    state = gait.initial()
    for i, duration in enumerate([*durations, p.T_start]):
        command = GaitCommand(walk=i < 6)
        early, before = gait.step(state, duration - (gap if i == 0 else 2 * gap), command)
        late, state = gait.step(before, 2 * gap, command)
        assert early.phase != late.phase
        for old, new in zip(gait.com_motion(before), gait.com_motion(state), strict=True):
            assert new.position == pytest.approx(old.position, abs=1e-9)
            assert new.velocity == pytest.approx(old.velocity, abs=1e-9)
    assert late.phase == "stand"
    assert late.com == pytest.approx((3 * plan.length + BODY.foot.centre[0], 0.0), abs=1e-12)


def test_steps_follow_each_other_as_in_the_thesis_and_the_last_brings_the_feet_together() -> None:
    gait = DynamicGait(parameters(), BODY)
    walked = list(dry_walk(gait, 0.01, 4))
    plans = [plan for plan, _ in walked]
    order = [now.phase for now, after in itertools.pairwise(plans) if now.phase != after.phase]
    assert order == ["start", "SSR", "DSL", "SSL", "DSR", "SSR", "DSL", "SSL", "stop"]
    last = plans[-1]
    assert last.step == 4
    assert last.left.x == last.right.x == pytest.approx(3 * 0.09134, abs=2e-5)
    state = walked[-1][1]
    assert gait.step(state, 0.01, GaitCommand(walk=False)) == walked[-1]
    assert gait.step(state, 0.01, GaitCommand(walk=True))[0].phase == "start"


def test_told_to_stop_before_the_first_step_it_returns_to_rest_where_it_stood() -> None:
    gait = DynamicGait(parameters(), BODY)
    plan, state = gait.step(gait.initial(), 0.01, GaitCommand(walk=True))
    for _ in range(round(2.0 / 0.01) + 2):
        plan, state = gait.step(state, 0.01, GaitCommand(walk=False))
    assert plan == standing_plan(gait)


def test_stance_feet_rest_and_swing_feet_land_softly() -> None:
    h = 1e-4
    plans = list(walk(DynamicGait(parameters(), BODY), 4, h))
    for before, now in itertools.pairwise(plans):
        if now.support in ("L", "both") and before.support in ("L", "both"):
            assert (now.left.x, now.left.z) == (before.left.x, before.left.z)
        if before.support != "both" and now.support == "both":  # touch-down
            for old, new in ((before.left, now.left), (before.right, now.right)):
                assert math.dist((old.x, old.z), (new.x, new.z)) / h < 1e-2
                assert new.z == 0.0
    assert max(plan.left.z for plan in plans) == pytest.approx(0.025, abs=1e-6)


def support_polygon(plan: Plan, body: Body) -> Array:
    """Corners of the soles on the ground."""
    corners = []
    if plan.support in ("L", "both"):
        corners += [(plan.left.x + x, plan.left.y + y) for x, y in body.foot.sole]
    if plan.support in ("R", "both"):
        corners += [(plan.right.x + x, plan.right.y - y) for x, y in body.foot.sole]
    return np.array(corners)


def inside_hull(point: tuple[float, float], corners: Array) -> bool:
    """A point is outside a convex hull exactly if all corners fit into an open half turn about it."""
    away = corners - point
    angles = np.sort(np.arctan2(away[:, 1], away[:, 0]))
    gaps = np.diff(angles, append=angles[0] + 2.0 * math.pi)
    return bool(gaps.max() <= math.pi + 1e-9)


@settings(max_examples=30)
@given(
    e_s1=st.floats(0.005, 0.05),
    ratio=st.floats(0.02, 0.95),
    S_a0=st.floats(0.001, 0.06),
    z=st.floats(0.18, 0.30),
    l_FA=st.floats(0.08, 0.13),
    T_start=st.floats(0.3, 2.5),
    body=st.sampled_from(BODIES),
)
def test_an_admissible_set_keeps_the_zmp_in_the_feet_and_the_mass_within_friction(
    e_s1: float, ratio: float, S_a0: float, z: float, l_FA: float, T_start: float, body: str
) -> None:
    p = parameters(e_s1=e_s1, e_su=ratio * e_s1, S_a0=S_a0, z=z, l_FA=l_FA, T_start=T_start, mu=0.6)
    robot = load_body(body)
    try:
        gait = DynamicGait(p, robot)
    except ConfigurationError:
        assume(False)
    for plan, state in dry_walk(gait, 0.013, 3):
        assert inside_hull(plan.zmp, support_polygon(plan, robot)), (plan.phase, plan.progress)
        assert math.hypot(*(m.acceleration for m in gait.com_motion(state))) <= p.mu * G + 1e-9
        if plan.phase in ("SSL", "SSR"):  # assumption 6: the x axis is not crossed in single support
            assert plan.com[1] * (1.0 if plan.support == "L" else -1.0) > 0.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"e_s1": 0.052}, r"e_s1 = 0.052 m reaches 2.0 mm beyond .* less than d_0 = l_FA / 2 = 0.05 m"),
        ({"e_su": 0.031}, r"e_su = 0.031 m is 1.0 mm too large .* less than e_s1 = 0.03 m"),
        ({"mu": 0.2}, r"friction bound mu g \(3.9\); mu must be at least 0.261"),
        ({"l_FA": 0.07}, r"soles overlap by 7.5 mm; l_FA must be at least 0.0775 m"),
        ({"l_GH": 0.2}, r"leg is stretched [0-9.]+ mm beyond its 0.2027 m"),
        ({"l_lift": 0.06}, r"leg is folded [0-9.]+ mm below the 0.0998 m"),
        (
            {"e_s1": 0.01, "e_su": 0.0099, "S_a0": 0.02, "mu": 99.0},
            r"S_a0 = 0.02 m the ZMP leaves the feet by [0-9.]+ mm in double support",
        ),
        ({"T_start": 4.0}, r"ZMP leaves the feet by [0-9.]+ mm on the way from rest to A"),
        ({"e_s1": 0.02, "T_start": 0.3, "mu": 0.3}, r"while starting and stopping, 3.22 m.s.2, is 0.28"),
        ({"T_start": 0.2, "mu": 9.0}, r"T_start = 0.2 s the ZMP leaves the feet by"),
    ],
)
def test_an_inadmissible_set_is_refused_with_the_bound_it_violates(
    changes: dict[str, float], message: str
) -> None:
    with pytest.raises(ConfigurationError, match=message):
        DynamicGait(parameters(**changes), BODY)


@pytest.mark.parametrize("body", BODIES)
def test_every_body_can_walk_the_shipped_parameters(body: str) -> None:
    robot = load_body(body)
    assert [plan.phase for plan in walk(DynamicGait(parameters(), robot), 2)][-1] == "stand"
