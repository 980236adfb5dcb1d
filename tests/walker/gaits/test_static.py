"""The statically stable gait against 3.3.1 and figure 3.4 of the thesis, and against scipy's splines."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from bridge.body import BODIES, load_body
from bridge.errors import ConfigurationError
from walker.gaits import GaitCommand, dry_walk, gait_parameters, make_gait, standing_plan
from walker.gaits.catalogue import check_walkable

DT = 0.01


def walk(steps=6, **changes):
    body = load_body("nao-v3")
    gait = make_gait("static", gait_parameters("static", changes), body)
    return body, [standing_plan(gait), *(plan for plan, _ in dry_walk(gait, DT, steps))]


def test_phases_follow_one_another_with_the_durations_of_figure_3_4():
    _, references = walk()
    phases = [r.phase for r in references[1:-1]]
    runs = [[phases[0], 0]]
    for phase in phases:
        if phase != runs[-1][0]:
            runs.append([phase, 0])
        runs[-1][1] += 1
    assert [name for name, _ in runs] == [*("DSL", "SSL", "DSR", "SSR") * 3, "stop"]
    for name, cycles in runs:
        assert cycles * DT == pytest.approx(1.5 if name.startswith("SS") else 2.0, abs=1.01 * DT)


def test_each_foot_stands_still_while_it_bears_weight_and_steps_twice_the_step_length():
    _, references = walk()
    for before, after in itertools.pairwise(references):
        if after.support in ("L", "both") and before.support in ("L", "both"):
            assert (after.left.x, after.left.z) == (before.left.x, 0.0)
        if after.support in ("R", "both") and before.support in ("R", "both"):
            assert (after.right.x, after.right.z) == (before.right.x, 0.0)
    landings = sorted({r.left.x for r in references if r.support == "both"})
    assert np.diff(landings) == pytest.approx([0.12, 0.12, 0.06], abs=1e-12)
    assert references[-1].left.x == references[-1].right.x == pytest.approx(5 * 0.06)


def test_swing_foot_reaches_the_lift_at_half_time():
    _, references = walk()
    lifts = [r for r in references if r.phase == "SSL"]
    assert max(r.right.z for r in lifts) == pytest.approx(0.035, abs=1e-9)


def test_zmp_rests_in_the_middle_of_the_stance_foot_in_single_support():
    body, references = walk()
    x, y = body.foot.centre
    for r in references:
        if r.support == "L":
            assert r.zmp == pytest.approx((r.left.x + x, r.left.y + y), abs=1e-12)
        if r.support == "R":
            assert r.zmp == pytest.approx((r.right.x + x, r.right.y - y), abs=1e-12)


def test_centre_of_mass_moves_without_jumps_in_position_or_velocity():
    _, references = walk()
    com = np.array([r.com for r in references])
    velocity = np.diff(com, axis=0) / DT
    # The quintic's largest acceleration is 10/sqrt(3) way / T^2.
    largest = 10.0 / np.sqrt(3.0) * np.array([0.06, 0.1068]) / 2.0**2
    assert np.all(np.abs(np.diff(velocity, axis=0)) / DT <= largest * 1.01)


def test_a_walk_called_off_at_the_start_stays_where_it_is():
    body = load_body("nao-v3")
    gait = make_gait("static", gait_parameters("static"), body)
    plan, state = gait.step(gait.initial(), DT, GaitCommand(walk=False))
    assert state == gait.initial()
    assert plan == standing_plan(gait)


def test_steps_take_the_velocity_of_the_command_from_the_next_one_on():
    gait = make_gait("static", gait_parameters("static"), load_body("nao-v3"))
    state, places = gait.initial(), []
    for cycle in range(round(4 * 3.5 / DT)):
        velocity = (0.04 / 3.5, 0.0, 0.0) if cycle * DT > 3.5 else None
        plan, state = gait.step(state, DT, GaitCommand(walk=True, velocity=velocity))
        places.append(max(plan.left.x, plan.right.x))
    steps = np.diff(sorted({round(x, 9) for x, after in itertools.pairwise(places) if x == after}))
    assert steps[steps > 1e-6] == pytest.approx([0.06, 0.04, 0.04], abs=1e-6)


def test_a_step_changes_nothing_but_what_it_returns():
    gait = make_gait("static", gait_parameters("static"), load_body("nao-v3"))
    states = [state for _, state in itertools.islice(dry_walk(gait, 0.1), 60)]
    command = GaitCommand(walk=True)
    first = [gait.step(state, 0.1, command) for state in states]
    assert [gait.step(state, 0.1, command) for state in states] == first


@pytest.mark.parametrize("name", BODIES)
def test_every_body_can_walk_the_shipped_parameters(name):
    body = load_body(name)
    check_walkable(body, make_gait("static", gait_parameters("static"), body))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"l_SW": 0.12}, "out of reach"),
        ({"l_GH": 0.20}, "out of reach"),
        ({"T_DSP": 0.3}, "T_DSP must be longer"),
    ],
)
def test_a_gait_that_cannot_be_walked_is_refused_by_its_bound(changes, says):
    body = load_body("nao-v3")
    with pytest.raises(ConfigurationError, match=says):
        check_walkable(body, make_gait("static", gait_parameters("static", changes), body))
