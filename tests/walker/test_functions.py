"""Trajectory pieces against the splines of SciPy, the linear pendulum against its integrated equation."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.interpolate import BPoly, CubicSpline

from bridge.body.quantities import GRAVITY
from walker.functions import LinearPendulum, capture_point, lift_spline, quintic

COORDINATE = st.floats(-0.3, 0.3)


def test_the_motion_is_the_equations_integral():
    # (3.4): x'' = (g / z) x, with the zero moment point at 0.
    pendulum, start, end = LinearPendulum(0.23), (0.03, -0.2), 0.4
    # Figures 3.6, 3.7 of the thesis: z = 0.23 m gives nu = 6.5309 1/s.
    assert pendulum.nu == pytest.approx(6.5309, abs=1e-4)
    solution = solve_ivp(lambda t, s: [s[1], GRAVITY / 0.23 * s[0]], (0.0, end), start, rtol=1e-11, atol=1e-13)
    motion = pendulum.motion(end, *start)
    assert motion[:2] == pytest.approx(solution.y[:, -1], rel=1e-7)
    assert pendulum.zmp(motion.position, motion.acceleration) == pytest.approx(0.0, abs=1e-12)


def test_forward_acceleration_moves_the_zmp_back():
    # (3.4) by hand: 0.24525 m high, 1 m/s^2 forward: x = -0.24525 / 9.81.
    assert LinearPendulum(0.24525).zmp(0.0, 1.0) == pytest.approx(-0.025)


@given(x=COORDINATE, v=st.floats(-1.0, 1.0), z=st.floats(0.1, 0.4))
def test_at_the_capture_point_the_motion_comes_to_rest(x, v, z):
    pendulum = LinearPendulum(z)
    rest = capture_point((x, 0.0), (v, 0.0), pendulum.nu)[0]
    assert pendulum.motion(2.0, x - rest, v)[:2] == pytest.approx((0.0, 0.0), abs=1e-3)


length = st.floats(-1.0, 1.0)


duration = st.floats(0.1, 5.0)


share = st.floats(0.0, 1.0)


@given(length, length, duration, share)
def test_quintic_is_the_polynomial_from_rest_to_rest(start, end, T, s):
    """BPoly.from_derivatives finds (3.6) from its six end conditions by another way."""
    poly = BPoly.from_derivatives([0.0, T], [[start, 0.0, 0.0], [end, 0.0, 0.0]])
    motion = quintic(start, end, T, s * T)
    assert motion.position == pytest.approx(poly(s * T), abs=1e-9)
    assert motion.velocity == pytest.approx(poly.derivative()(s * T), abs=1e-7)
    assert motion.acceleration == pytest.approx(poly.derivative(2)(s * T), abs=1e-5)


@given(length, length, length, duration, share)
def test_lift_is_the_clamped_cubic_spline(start, middle, end, T, s):
    spline = CubicSpline([0.0, T / 2, T], [start, middle, end], bc_type="clamped")
    motion = lift_spline(start, middle, end, T, s * T)
    assert motion.position == pytest.approx(spline(s * T), abs=1e-9)
    assert motion.velocity == pytest.approx(spline(s * T, 1), abs=1e-7)
