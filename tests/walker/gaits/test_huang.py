"""The walking cycle as a phase machine: whole walks on flat and known ground."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.sole import sole_hull
from bridge.errors import ConfigurationError
from bridge.ground import KnownGround, Patch
from bridge.polygon import SupportPolygon, convex_hull
from walker.gaits import GaitCommand, Plan, dry_walk, gait_parameters, make_gait, standing_plan
from walker.gaits.catalogue import check_walkable
from walker.gaits.huang import HuangGait, HuangParameters

BODY = load_body("nao-v3")
CHOICE = {"x_sd": 0.0186, "x_ed": 0.0169, "y_d": 0.0194, "y_m": 0.0410, "progress": 1.0}
"""What the search finds, named, so that these tests need none."""
DT = 0.01


def gait(**changes: object) -> HuangGait:
    made = make_gait("huang", gait_parameters("huang", CHOICE | changes), BODY)
    assert isinstance(made, HuangGait)
    return made


def walk(made: HuangGait, steps: int, dt: float = DT) -> list[Plan]:
    return [standing_plan(made), *(plan for plan, _ in dry_walk(made, dt, steps))]


def test_walks_the_steps_that_were_asked_for_and_closes_the_feet() -> None:
    made = gait()
    plan = walk(made, 5)
    last = plan[-1]
    assert last.step == 5 and last.phase == "stand"
    assert last.left.x == pytest.approx(last.right.x, abs=1e-12)
    assert last.left.x == pytest.approx(4 * made.parameters.D_s, abs=1e-12)
    assert (last.left.pitch, last.right.pitch) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert last.com[1] == pytest.approx(0.0, abs=1e-3)
    phases = [plan[0].phase]
    for reference in plan:
        if reference.phase != phases[-1]:
            phases.append(reference.phase)
    assert phases[:6] == ["stand", "start", "DSL", "SSL", "DSR", "SSR"] and phases[-2:] == ["stop", "stand"]


def test_stopping_on_the_way_to_the_first_step_is_a_stand_without_a_step() -> None:
    made = gait()
    state = made.initial()
    for cycle in range(200):
        reference, state = made.step(state, DT, GaitCommand(walk=cycle < 20))
    assert reference.phase == "stand"
    assert reference.step == 0 and reference.left.x == reference.right.x == 0.0
    again, _ = made.step(state, DT, GaitCommand(walk=True))
    assert again.phase == "start"


def test_hip_and_feet_move_smoothly() -> None:
    """Nothing jumps: neither places nor velocities, from rest through cycles to rest."""
    dt = 0.002
    plan = walk(gait(), 4, dt)
    rows = np.array(
        [
            (*r.com, r.hip_height, r.left.x, r.left.z, r.left.pitch, r.right.x, r.right.z, r.right.pitch)
            for r in plan
        ]
    )
    acceleration = np.abs(np.diff(rows, 2, axis=0)) / dt**2
    assert acceleration[:, :3].max() < 6.0
    assert acceleration[:, [3, 4, 6, 7]].max() < 20.0
    assert acceleration[:, [5, 8]].max() < 40.0


def test_planned_zmp_stays_in_the_soles_from_rest_to_rest() -> None:
    """Single supports in the stance sole, everything else in the hull of both: margin over 5 mm."""
    outline = {"left": sole_hull(BODY, "L"), "right": sole_hull(BODY, "R")}
    least = math.inf
    for r in walk(gait(), 5):
        sides = {"L": ["left"], "R": ["right"], "both": ["left", "right"]}[r.support]
        corners = [
            corner for side in sides for corner in outline[side] + (getattr(r, side).x, getattr(r, side).y)
        ]
        least = min(least, SupportPolygon(convex_hull(corners)).margin(r.zmp))
    assert least > 0.005


def test_known_step_up_and_down() -> None:
    """Soles stand level or hang over an edge by no more than allowed; nothing cuts into the ground."""
    ground = KnownGround(patches=(Patch(x=(0.35, 0.8), y=(-1.0, 1.0), height=0.01),))
    made = gait(ground=msgspec.to_builtins(ground))
    along = sole_hull(BODY, "L")[:, 0]
    stands = set()
    for r in walk(made, 22):
        for foot in (r.left, r.right):
            s, c = math.sin(foot.pitch), math.cos(foot.pitch)
            for t in along:
                x, z = foot.x + c * t, foot.z - s * t
                assert z > ground.height(x, (foot.y,)) - 1e-3
            if r.support == "both" and foot.pitch == 0.0:
                stands.add((round(foot.x, 6), round(foot.z, 6)))
    assert {z for _, z in stands} == {0.0, 0.01}
    over = made.parameters.overhang
    for x, z in stands:
        for t in (along.min() + over, along.max() - over):
            assert ground.height(x + t, (0.05,)) == z
    assert max(x for x, z in stands if z == 0.0) > 0.9
    assert max(x for x, z in stands if z == 0.01) < 0.8


def test_slope_is_followed_by_feet_and_hip() -> None:
    slope = -0.05
    made = gait(ground={"slope": slope})
    for r in walk(made, 6):
        if r.support == "both" and r.phase == "stand":
            assert r.left.pitch == pytest.approx(slope)
            assert r.left.z == pytest.approx(-math.tan(slope) * r.left.x, abs=1e-9)
    assert r.left.x == pytest.approx(5 * made.parameters.D_s, abs=1e-9)
    assert r.hip_height == pytest.approx(made.parameters.H_min + math.tan(-slope) * r.left.x, abs=2e-3)


def test_a_step_too_high_or_edges_too_near_are_refused() -> None:
    high = KnownGround(patches=(Patch(x=(0.35, 0.8), y=(-1.0, 1.0), height=0.06),))
    with pytest.raises(ConfigurationError, match=r"into the known ground|its range|out of reach"):
        gait(ground=msgspec.to_builtins(high))
    stairs = tuple(Patch(x=(0.3 + 0.06 * i, 3.0), y=(-1.0, 1.0), height=0.004 * (i + 1)) for i in range(8))
    with pytest.raises(ConfigurationError, match=r"no steps of up to D_max = 0.13 m lead from x = "):
        gait(ground=msgspec.to_builtins(KnownGround(patches=stairs)))


def test_every_body_walks_it() -> None:
    """The default, its hip searched anew, is within reach and joint ranges of the other bodies' extremes."""
    for name in ("nao-v3", "nao-v6"):
        body = load_body(name)
        p = gait_parameters("huang", CHOICE)
        assert isinstance(p, HuangParameters)
        check_walkable(body, make_gait("huang", p, body))
