"""Zero moment points against the balance of moments, with every force written out."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bridge.datasheet import BODIES, load_body
from walker.errors import NoSupportError
from walker.gravity import GRAVITY
from walker.kinematics.transforms import homogeneous, rotation
from walker.support_polygon import SupportPolygon, convex_hull
from walker.zmp import FootForces, LinearPendulum, pendulum_zmp

V3 = load_body("nao-v3")
MASS = 4.7


def standing(x, y, yaw=0.0, z=0.04511):
    return homogeneous(rotation(0.0, 0.0, yaw), [x, y, z])


COORDINATE = st.floats(-0.3, 0.3)
ACCELERATION = st.floats(-5.0, 5.0)


@settings(deadline=None)
@given(
    com=st.tuples(COORDINATE, COORDINATE, st.floats(0.1, 0.4)),
    acceleration=st.tuples(ACCELERATION, ACCELERATION, ACCELERATION),
    moment=st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)),
)
def test_horizontal_moments_vanish_at_the_zmp(com, acceleration, moment):
    # Definition before (3.1): inertial, gravity and external moments have no horizontal part about that point.
    x, y = pendulum_zmp(com, acceleration, mass=MASS, moment=moment)
    force = -MASS * (np.array(acceleration) + np.array([0.0, 0.0, GRAVITY]))
    inertial = np.cross(np.array(com) - np.array([x, y, 0.0]), force)
    assert inertial[:2] == pytest.approx([-moment[0], -moment[1]], abs=1e-12)


def test_moments_press_the_edge_they_turn_towards():
    # Right hand rule: about +y the robot tips forward, about +x to its right.
    level, com = (0.0, 0.0, 0.0), (0.0, 0.0, 0.25)
    assert pendulum_zmp(com, level, mass=MASS) == (0.0, 0.0)
    weight = MASS * GRAVITY
    assert pendulum_zmp(com, level, mass=MASS, moment=(0.0, 1.0)) == pytest.approx((1.0 / weight, 0.0))
    assert pendulum_zmp(com, level, mass=MASS, moment=(1.0, 0.0)) == pytest.approx((0.0, -1.0 / weight))


def test_forward_acceleration_moves_the_zmp_back():
    # (3.3a) by hand: 0.25 m high, 1 m/s^2 forward, 0.19 m/s^2 up: x = -0.25 / 10.
    assert pendulum_zmp((0.0, 0.0, 0.25), (1.0, -2.0, 0.19), mass=1.0) == pytest.approx((-0.025, 0.05))


@pytest.mark.parametrize("a_z", [-GRAVITY, -20.0, math.nan])
def test_free_fall_has_no_zmp(a_z):
    with pytest.raises(NoSupportError, match="no zero moment point"):
        pendulum_zmp((0.0, 0.0, 0.25), (1.0, 0.0, a_z), mass=MASS)


def test_linear_pendulum_moves_as_its_equation_integrates():
    # (3.4): x'' = (g / z) (x - zmp), integrated numerically.
    pendulum, zmp, start, end = LinearPendulum(0.23), 0.01, (0.03, -0.2), 0.4
    # Figures 3.6, 3.7 of the thesis: z = 0.23 m gives nu = 6.5309 1/s.
    assert pendulum.nu == pytest.approx(6.5309, abs=1e-4)
    solution = solve_ivp(
        lambda t, s: [s[1], GRAVITY / 0.23 * (s[0] - zmp)], (0.0, end), start, rtol=1e-11, atol=1e-13
    )
    assert pendulum.after(end, *start, zmp) == pytest.approx(solution.y[:, -1], rel=1e-7)


@settings(deadline=None)
@given(x=COORDINATE, v=st.floats(-1.0, 1.0), a=ACCELERATION, z=st.floats(0.1, 0.4))
def test_linear_pendulum_agrees_with_the_general_one(x, v, a, z):
    pendulum = LinearPendulum(z)
    assert pendulum.zmp(x, a) == pytest.approx(pendulum_zmp((x, 0.0, z), (a, 0.0, 0.0), mass=1.0)[0], abs=1e-12)
    # At the capture point the motion runs out: x -> zmp, v -> 0.
    rest = pendulum.capture_point(x, v)
    assert pendulum.after(2.0, x, v, rest) == pytest.approx((rest, 0.0), abs=1e-3)


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("side", ["L", "R"])
@pytest.mark.parametrize("cell", range(4))
def test_a_single_sensor_has_the_pressure_where_it_sits(name, side, cell):
    body = load_body(name)
    forces = [0.0] * 4
    forces[cell] = 7.0
    place = getattr(body.fsr, side)[cell]
    assert FootForces(body).centre_of_pressure(side, forces) == pytest.approx(place[:2], abs=1e-15)


def test_even_load_is_in_the_middle_of_the_four_places():
    # Table 4.1, left foot: x = (2 * 70.25 - 30.25 - 29.65) / 4, y = (2 * 29.9 - 23.1 - 19.1) / 4 mm.
    x, y = FootForces(V3).centre_of_pressure("L", [5.0] * 4)
    assert (x, y) == pytest.approx((0.02015, 0.0044), abs=1e-12)


FORCES = st.lists(st.floats(0.0, 25.0), min_size=8, max_size=8)


@settings(deadline=None)
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
    x, y = forces.centre_of_pressure("L", fsr[:4])
    assert forces.zmp(fsr, {"L": standing(0.1, 0.2)}) == pytest.approx([0.1 + x, 0.2 + y, 0.0], abs=1e-15)
    assert forces.zmp(fsr, {}) is None


def test_negative_readings_are_no_suction():
    forces = FootForces(V3)
    assert forces.centre_of_pressure("R", [3.0, -0.2, 5.0, -1.0]) == forces.centre_of_pressure(
        "R", [3.0, 0.0, 5.0, 0.0]
    )
    assert forces.centre_of_pressure("R", [-3.0, 0.2, 0.2, -1.0]) is None


def test_a_tilted_foot_bears_with_the_vertical_part_of_its_forces():
    # Left foot level, right foot pitched by 60 degrees about its ankle, equal loads: cos 60 = half the weight.
    forces, even = FootForces(V3), [4.0] * 8
    tilted = homogeneous(rotation(0.0, math.pi / 3, 0.0), [0.2, -0.05, 0.04511])
    feet = {"L": standing(0.0, 0.05), "R": tilted}
    left, right = forces.zmp(even, {"L": feet["L"]}), forces.zmp(even, {"R": feet["R"]})
    assert forces.zmp(even, feet) == pytest.approx((left + 0.5 * right) / 1.5, abs=1e-12)
