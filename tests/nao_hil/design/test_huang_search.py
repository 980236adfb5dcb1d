"""Multi-body ZMP, support and search: against statics, poses one by one, and the claims of the default gait."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.kinematics import CentreOfMass
from bridge.polygon import SupportPolygon, convex_hull
from nao_hil.design.huang.cycle import Cycle, contact
from nao_hil.design.huang.motions import sample_x, sample_y
from nao_hil.design.huang.search import GRID, CyclePlan, along, search
from walker.gaits import gait_parameters
from walker.gaits.huang import HuangParameters
from walker.gaits.huang.foot import FootShape
from walker.gaits.huang.hip import Choice, choice_of
from walker.gaits.huang.multibody import Ankle, Bodies
from walker.gaits.pose import ARMS

BODY = load_body("nao-v3")
CHOICE = Choice(0.0186, 0.0169, 0.0194, 0.0410)


@pytest.fixture(scope="module")
def cycle() -> Cycle:
    p = gait_parameters("huang")
    assert isinstance(p, HuangParameters)
    return Cycle(p, BODY, ARMS)


def test_at_rest_the_zmp_is_below_the_centre_of_mass() -> None:
    bodies = Bodies(BODY, ARMS)
    an = BODY.lengths.FootHeight
    hip, left, right = (0.03, 0.01, 0.2), Ankle(0.02, 0.05, an, 0.0), Ankle(-0.02, -0.05, an + 0.01, 0.1)
    frames = bodies.frames(hip, left, right)
    torso = np.array([*hip[:2], hip[2] + BODY.lengths.HipOffsetZ])
    com = torso + CentreOfMass(BODY)(bodies.joint_angles(hip, left, right))
    assert bodies.centre_of_mass(frames) == pytest.approx(com, abs=1e-12)
    assert bodies.zmp(frames, frames, frames) == pytest.approx(com[:2], abs=1e-12)


def test_a_body_that_only_turns_moves_the_zmp_by_its_inertia() -> None:
    """The rotation terms alone: L' / (m g), (13) with its sign, (14) with the opposite of the printed one."""
    bodies = Bodies(BODY, ARMS)
    an = BODY.lengths.FootHeight
    now = bodies.frames((0.0, 0.0, 0.2), Ankle(0.0, 0.05, an, 0.0), Ankle(0.0, -0.05, an, 0.0))
    torso = BODY.links["Torso"]
    step, alpha = 1e-3, 2.0
    for axis, index in (("y", 1), ("x", 0)):
        moved = []
        for sign in (-1.0, 1.0):
            turn = 0.5 * alpha * step**2  # at rest now, so both neighbours are turned alike
            c, s = np.cos(turn), np.sin(turn)
            rotation = {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]]}[axis]
            frames = now.copy()
            frames[0, :3, :3] = np.array(rotation)
            # About its own centre of mass.
            frames[0, :3, 3] += (np.eye(3) - np.array(rotation)) @ np.array(torso.com)
            moved.append(frames)
            assert sign
        found = bodies.zmp(moved[0], now, moved[1], step)
        still = bodies.zmp(now, now, now, step)
        arm = torso.inertia[index] * alpha / (bodies.mass.sum() * 9.81)
        if axis == "y":
            assert found[0] - still[0] == pytest.approx(-arm, rel=1e-4)
        else:
            assert found[1] - still[1] == pytest.approx(arm, rel=1e-4)


def test_table_agrees_with_poses_one_by_one(cycle: Cycle) -> None:
    """Over the whole range of the search, to a micrometre.

    At the knots the differences of the poses reach over a kink of the acceleration, and are themselves off by a
    fifth of a millimetre.
    """
    p = cycle.p
    knots = np.array([0.0, p.T_d, p.T_m, 0.5 * (p.T_c + p.T_d)])
    smooth = np.abs(cycle.times[:, None] - knots).min(axis=1) > 2e-3
    rng = np.random.default_rng(0)
    bound = 0.5 * cycle.p.D_s
    corners = np.array([0.0, 0.0, bound, bound]), np.array([0.0, bound, 0.0, bound])
    motions = sample_x(cycle.p, cycle.times)
    table = cycle.table(CHOICE, "x", motions, corners)
    for x_sd, x_ed in rng.uniform(0.05 * bound, 0.95 * bound, (3, 2)):
        found = table.zmp(motions.at(np.array([x_sd]), np.array([x_ed])))
        direct = cycle.zmp(CHOICE._replace(x_sd=x_sd, x_ed=x_ed))
        for table_zmp, pose_zmp in zip(found, direct, strict=True):
            apart = np.abs(table_zmp[:, 0] - pose_zmp)
            assert apart[smooth].max() < 1e-6
            assert apart.max() < 5e-4
    motions = sample_y(cycle.p, cycle.times)
    table = cycle.table(CHOICE, "y", motions, (np.array([0.0, 0.03]), np.array([0.03, 0.05])))
    found = table.zmp(motions.at(np.array([0.021]), np.array([0.037])))
    direct = cycle.zmp(CHOICE._replace(y_d=0.021, y_m=0.037))
    assert np.abs(found[1][:, 0] - direct[1])[smooth].max() < 1e-6


def test_margins_agree_with_the_walkers_polygon(cycle: Cycle) -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform((-0.08, -0.12), (0.18, 0.12), (40, 2))
    x, y = (
        np.broadcast_to(points[:, 0], (len(cycle.times), 40)),
        np.broadcast_to(points[:, 1], (len(cycle.times), 40)),
    )
    found = cycle.support.margins(x, y)
    for i in (0, 4, 9, 13, 20, 45):
        polygon = SupportPolygon(convex_hull(cycle.support.polygons[i].tolist()))
        for k, point in enumerate(points):
            expected = polygon.margin(point)
            if expected >= 0.0:
                assert found[i, k] == pytest.approx(expected, abs=1e-9)
            else:
                assert found[i, k] < 1e-9


def test_contact_follows_heel_and_toe() -> None:
    """A tilted sole bears where it is less than the give above the ground, about the edge it rolls on."""
    shape = FootShape(0.045, 0.10, 0.05)
    sole = np.array([(-0.05, -0.03), (0.10, -0.03), (0.10, 0.03), (-0.05, 0.03)])
    flat = contact(sole, shape, 0.0, shape.l_an, 0.0, 1e-3)
    assert flat[:, 0].min() == pytest.approx(-0.05) and flat[:, 0].max() == pytest.approx(0.10)
    pitch = 0.05
    s, c = np.sin(pitch), np.cos(pitch)
    toe = contact(sole, shape, 0.0, shape.l_af * s + shape.l_an * c, pitch, 1e-3)
    assert np.ptp(toe[:, 0]) == pytest.approx(1e-3 / np.tan(pitch), rel=1e-9)
    assert toe[:, 0].max() == pytest.approx(shape.l_af * c - shape.l_an * s)
    heel = contact(sole, shape, 0.0, shape.l_ab * s + shape.l_an * c, -pitch, 1e-3)
    assert np.ptp(heel[:, 0]) == pytest.approx(1e-3 / np.tan(pitch), rel=1e-9)
    assert len(contact(sole, shape, 0.0, shape.l_an + 0.002, 0.0, 1e-3)) == 0


@pytest.fixture(scope="module")
def found(cycle: Cycle) -> CyclePlan:
    """As shipped; `test_huang_plans.py` searches it anew."""
    choice = choice_of(cycle.p, BODY)
    return CyclePlan(choice, cycle.margin(choice))


def test_default_optimum_is_inside_the_grid_and_stays_when_it_is_refined(
    cycle: Cycle, found: CyclePlan
) -> None:
    _, fine = along(cycle, found.choice, 2 * GRID)
    _, coarse = along(cycle, found.choice)
    i, j = coarse.best()
    last = GRID - 1
    assert 0 < i < last and 0 < j < last
    k, m = fine.best()
    assert 0 < k < 2 * last + 1 and 0 < m < 2 * last + 1
    cell = coarse.first[1] - coarse.first[0]
    assert abs(coarse.first[i] - fine.first[k]) <= cell
    assert abs(coarse.second[j] - fine.second[m]) <= cell
    # the choice itself lies between the points of the grids, and is no worse than any of them
    assert found.margin >= fine.margin.max() - 5e-5
    assert found.margin > 0.02


def test_no_neighbour_by_poses_alone_has_more_margin(cycle: Cycle) -> None:
    """In any direction of all four numbers, by the poses of (13), (14) and no table (to 0.05 mm)."""
    found = search(Cycle(msgspec.structs.replace(cycle.p, y_d=None, y_m=None), BODY, ARMS))
    rng = np.random.default_rng(2)
    for length in (2e-4, 1e-3, 4e-3):
        for direction in rng.normal(size=(8, 4)):
            moved = np.array(found.choice) + length * direction / np.linalg.norm(direction)
            assert cycle.margin(Choice(*moved.tolist())) < found.margin + 5e-5
