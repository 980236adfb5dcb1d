"""The way of a foot against the source's own conditions (1) to (6), and against the ground."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.sole import sole_hull
from bridge.errors import ConfigurationError
from walker.gaits import gait_parameters, make_gait
from walker.gaits.huang import HuangParameters
from walker.gaits.huang.foot import FootPath, FootShape, Placement

BODY = load_body("nao-v3")
SHAPE = FootShape.of(BODY)
TOLERANCE = 1e-9


def parameters(**changes: object) -> HuangParameters:
    p = gait_parameters("huang", {"q_b": 0.08, "q_f": 0.06, "H_ao": 0.075} | changes)
    assert isinstance(p, HuangParameters)
    return p


def test_knots() -> None:
    """(1), (2), (3) as corrected: the toe's height is l_af sin q_b, not l_af cos q_b."""
    p = parameters()
    h_gs, h_ge = 0.004, 0.011
    path = FootPath(p, SHAPE, Placement(0.1, h_gs), Placement(0.1 + 2.0 * p.D_s, h_ge))
    an, af, ab = SHAPE.l_an, SHAPE.l_af, SHAPE.l_ab
    end = p.T_c + p.T_d
    sb, cb, sf, cf = math.sin(p.q_b), math.cos(p.q_b), math.sin(p.q_f), math.cos(p.q_f)
    expected = {
        0.0: (0.1, h_gs + an, 0.0),
        p.T_d: (0.1 + an * sb + af * (1.0 - cb), h_gs + af * sb + an * cb, p.q_b),
        p.T_c: (0.1 + 2.0 * p.D_s - an * sf - ab * (1.0 - cf), h_ge + ab * sf + an * cf, -p.q_f),
        end: (0.1 + 2.0 * p.D_s, h_ge + an, 0.0),
    }
    for time, values in expected.items():
        found = [motion.position for motion in path.motion(time)]
        assert found == pytest.approx(values, abs=TOLERANCE)
    apex = path.motion(p.T_m)
    assert apex[0].position == pytest.approx(0.1 + p.D_s, abs=TOLERANCE)
    assert apex[1].position == pytest.approx(h_ge + p.H_ao, abs=TOLERANCE)


@pytest.mark.parametrize("slope", [0.0, 0.05])
def test_twice_continuously_differentiable(slope: float) -> None:
    """Position, velocity, acceleration: where rolling and swing join, and at the knots of the splines."""
    p = parameters()
    path = FootPath(p, SHAPE, Placement(0.0, 0.0, slope), Placement(2.0 * p.D_s, 0.01, slope))
    for time, rolling in ((path.lift, path._toe), (path.land, path._heel)):
        for rolled, swung in zip(
            rolling.ankle(path.pitch.at(time)), (path.x.at(time), path.z.at(time)), strict=True
        ):
            assert tuple(rolled) == pytest.approx(tuple(swung), abs=TOLERANCE)
    for spline in (path.pitch, path.x, path.z):
        for i, knot in enumerate(spline.breaks[1:-1]):
            width = knot - spline.breaks[i]
            a, b, c, d = spline.coefficients[:, i]
            before = (
                ((a * width + b) * width + c) * width + d,
                (3 * a * width + 2 * b) * width + c,
                6 * a * width + 2 * b,
            )
            assert tuple(spline.at(float(knot))) == pytest.approx(before, abs=TOLERANCE)


def test_motion_is_the_derivative_of_its_position() -> None:
    p = parameters()
    path = FootPath(p, SHAPE, Placement(0.0), Placement(2.0 * p.D_s))
    step = 1e-5
    for time in (0.07, 0.2, 0.31, 0.44, 0.55):
        before, now, after = (path.motion(time + shift) for shift in (-step, 0.0, step))
        for a, b, c in zip(before, now, after, strict=True):
            assert b.velocity == pytest.approx((c.position - a.position) / (2 * step), abs=1e-6)
            assert b.acceleration == pytest.approx((c.velocity - a.velocity) / (2 * step), abs=1e-3)


@pytest.mark.parametrize(("q_b", "q_f"), [(0.0, 0.0), (0.05, 0.05), (0.12, 0.03), (0.03, 0.12)])
def test_never_in_the_ground_and_no_slip(q_b: float, q_f: float) -> None:
    p = parameters(q_b=q_b, q_f=q_f)
    path = FootPath(p, SHAPE, Placement(0.0), Placement(2.0 * p.D_s))
    times = np.linspace(0.0, path.settled, 3001)
    _, z = path.sole(times, sole_hull(BODY, "L")[:, 0])
    assert z.min() > -1e-12
    edges = path.sole(times, np.array([-SHAPE.l_ab, SHAPE.l_af]))
    rolls, lands = times <= p.T_d, times >= p.T_c
    toe, heel = edges[:, rolls, 1], edges[:, lands, 0]
    assert np.ptp(toe, axis=1).max() < 1e-12
    assert np.ptp(heel, axis=1).max() < 1e-12


def test_a_spline_through_the_printed_knots_cuts_into_the_ground() -> None:
    """Why the ankle follows the pitch while the sole rolls, and (3) is met at the knots only."""
    from scipy.interpolate import CubicSpline

    p = parameters()
    path = FootPath(p, SHAPE, Placement(0.0), Placement(2.0 * p.D_s))
    knots = np.array([0.0, p.T_d, p.T_m, p.T_c, p.T_c + p.T_d])
    z = CubicSpline(knots, [path.motion(t)[1].position for t in knots], bc_type="clamped")
    times = np.linspace(0.0, p.T_d, 200)
    lowest = (
        z(times)
        - SHAPE.l_af * np.sin(path.pitch.sample(times)[0])
        - SHAPE.l_an * np.cos(path.pitch.sample(times)[0])
    )
    assert lowest.min() < -1e-5


def test_refusals_name_bound_and_excess() -> None:
    cases = {
        (("x_sd", 0.035),): r"x_sd = 0.035 m violates bound \(11\) by 5.0 mm; .* 0.5 D_s = 0.03 m",
        (("x_ed", -0.002),): r"x_ed = -0.002 m violates bound \(11\) by 2.0 mm",
        (("T_d", 0.6),): r"T_d = 0.6 s must be less than T_c = 0.5 s, and exceeds it by 0.1 s",
        (("T_m", 0.1),): r"T_m = 0.1 s lies 0.04 s outside the swing",
        (("H_min", 0.215),): r"H_min = 0.215 m is 5.0 mm above H_max",
        (("H_ao", 0.044),): r"mm into the ground at 0\.\d+ s of its cycle",
        (("H_max", 0.250),): r"step 1, its first such pose: the left ankle is \d+\.\d+ mm out of reach",
        (("l_FA", 0.07),): r"the soles overlap by \d+\.\d mm",
        (("q_b", 0.5), ("H_ao", 0.12)): r"step 2: LKneePitch would stand \d+\.\d deg above its range",
        (("q_b", 0.5), ("q_f", 0.5), ("H_ao", 0.12)): r"step 2: LAnklePitch would stand .* deg below its range",
    }
    named = {"x_sd": 0.015, "x_ed": 0.015, "y_d": 0.02, "y_m": 0.04}
    for changes, sentence in cases.items():
        with pytest.raises(ConfigurationError, match=sentence):
            make_gait("huang", gait_parameters("huang", named | dict(changes)), BODY)
