"""Contacts and support of the legs; measured zero moment points against the balance of moments."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.body import BODIES, load_body
from bridge.body.kinematics import homogeneous
from bridge.polygon import SupportPolygon, convex_hull
from bridge.rotations import rotation
from tests.plans import supported_plan
from walker.estimation.contact import (
    ContactEstimator,
    ContactParameters,
    Contacts,
    FootForces,
    SupportState,
    SupportStateMachine,
    TouchDownParameters,
)

DT = 0.01


BOTH, LEFT, NEITHER = Contacts(True, True), Contacts(True, False), Contacts(False, False)


def test_a_foot_that_has_landed_is_a_stance_foot_when_its_phase_ends() -> None:
    machine = SupportStateMachine(TouchDownParameters(max_wait=0.5))
    assert machine.update(supported_plan("L"), LEFT, DT).role("R") == "swing"
    assert machine.update(supported_plan("L", 0.95), BOTH, DT).role("R") == "swing"  # early: the phase goes on
    assert machine.update(supported_plan("both"), BOTH, DT) == SupportState("both")


def test_a_late_foot_is_lowered_and_waited_for_within_bounds() -> None:
    machine = SupportStateMachine(TouchDownParameters(max_wait=0.2, search_depth=0.01, search_rate=0.04))
    machine.update(supported_plan("L"), LEFT, DT)
    searches, waits = [], []
    for _ in range(60):
        support_state = machine.update(supported_plan("both"), LEFT, DT)
        searches.append(support_state.search_depth)
        waits.append(support_state.wait)
    assert searches[:3] == pytest.approx([0.0004, 0.0008, 0.0012])  # rate x time
    assert max(searches) <= 0.01
    assert sum(waits) == pytest.approx(20, abs=1)
    assert support_state == SupportState(
        "both"
    )  # 0.01 m / 0.04 m/s = 0.25 s after the phase began it counts as landed


def test_a_late_foot_that_finds_ground_ends_the_wait() -> None:
    machine = SupportStateMachine(TouchDownParameters(max_wait=0.5))
    machine.update(supported_plan("L"), LEFT, DT)
    assert machine.update(supported_plan("both"), LEFT, DT).wait
    assert machine.update(supported_plan("both"), BOTH, DT) == SupportState("both")
    assert machine.update(supported_plan("both"), LEFT, DT) == SupportState("both")  # one landing per swing


def test_without_touch_down_parameters_the_plan_is_believed() -> None:
    machine = SupportStateMachine(None)
    machine.update(supported_plan("L"), LEFT, DT)
    assert machine.update(supported_plan("both"), NEITHER, DT) == SupportState("both", 0.5)


def test_contact_has_hysteresis() -> None:
    estimator = ContactEstimator(ContactParameters(on=3.0, off=1.5))
    seen = [estimator.update((f / 4,) * 4 + (0.0,) * 4).left for f in (0.0, 2.0, 2.9, 3.1, 2.0, 1.6, 1.4, 2.0)]
    assert seen == [False, False, False, True, True, True, False, False]


V3 = load_body("nao-v3")


def standing(x, y, yaw=0.0, z=0.04511):
    return homogeneous(rotation(0.0, 0.0, yaw), [x, y, z])


COORDINATE = st.floats(-0.3, 0.3)


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("side", ["L", "R"])
@pytest.mark.parametrize("cell", range(4))
def test_a_single_sensor_has_the_pressure_where_it_sits(name, side, cell):
    body = load_body(name)
    forces = [0.0] * 4
    forces[cell] = 7.0
    place = getattr(body.fsr, side)[cell]
    fsr = [*forces, *([0.0] * 4)] if side == "L" else [*([0.0] * 4), *forces]
    assert FootForces(body).zmp(fsr, {side: standing(0.0, 0.0)})[:2] == pytest.approx(place[:2], abs=1e-15)


FORCES = st.lists(st.floats(0.0, 25.0), min_size=8, max_size=8)


@given(
    fsr=FORCES,
    left=st.tuples(COORDINATE, COORDINATE, st.floats(-1.0, 1.0)),
    right=st.tuples(COORDINATE, COORDINATE, st.floats(-1.0, 1.0)),
)
def test_forces_of_both_feet_balance_about_the_zmp(fsr, left, right):
    feet = {"L": standing(*left), "R": standing(*right)}
    zmp = FootForces(V3).zmp(fsr, feet)
    if zmp is None:
        assert sum(fsr) <= 1.0 + 1e-9
        return
    assert sum(fsr) > 1.0 - 1e-9
    places = np.array(
        [(feet[side] @ [*p, 1.0])[:3] for side, four in (("L", V3.fsr.L), ("R", V3.fsr.R)) for p in four]
    )
    forces = np.column_stack([np.zeros(8), np.zeros(8), fsr])
    total = np.cross(places - zmp, forces).sum(axis=0)
    assert total[:2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert zmp[2] == pytest.approx(0.0, abs=1e-12)
    assert SupportPolygon(convex_hull(places[:, :2])).margin(zmp) >= -1e-12


def test_one_foot_counts_when_one_foot_stands():
    fsr = [1.0, 2.0, 3.0, 4.0, 9.0, 9.0, 9.0, 9.0]
    forces = FootForces(V3)
    x, y, _ = forces.zmp(fsr, {"L": standing(0.0, 0.0)})
    assert forces.zmp(fsr, {"L": standing(0.1, 0.2)}) == pytest.approx([0.1 + x, 0.2 + y, 0.0], abs=1e-15)
    assert forces.zmp(fsr, {}) is None


def test_negative_readings_are_no_suction():
    def right(*cells):
        return FootForces(V3).zmp([0.0] * 4 + list(cells), {"R": standing(0.0, 0.0)})

    assert right(3.0, -0.2, 5.0, -1.0) == pytest.approx(right(3.0, 0.0, 5.0, 0.0))
    assert right(-3.0, 0.2, 0.2, -1.0) is None


def test_a_tilted_foot_bears_with_the_vertical_part_of_its_forces():
    # Left foot level, right foot pitched by 60 degrees about its ankle, equal loads: cos 60 = half the weight.
    forces, even = FootForces(V3), [4.0] * 8
    tilted = homogeneous(rotation(0.0, math.pi / 3, 0.0), [0.2, -0.05, 0.04511])
    feet = {"L": standing(0.0, 0.05), "R": tilted}
    left, right = forces.zmp(even, {"L": feet["L"]}), forces.zmp(even, {"R": feet["R"]})
    assert forces.zmp(even, feet) == pytest.approx((left + 0.5 * right) / 1.5, abs=1e-12)
