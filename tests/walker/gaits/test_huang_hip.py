"""The hip's splines against (7), (8), (9) and the corrected closed form (10)."""

from __future__ import annotations

import numpy as np
import pytest

from nao_hil.design.huang.motions import sample_x, sample_y
from walker.gaits import gait_parameters
from walker.gaits.huang import HuangParameters
from walker.gaits.huang.hip import Choice, ends_of_cycle, hip_x, hip_y, hip_z

P = gait_parameters("huang", {"x_0": 0.0})
assert isinstance(P, HuangParameters)
CHOICE = Choice(0.017, 0.021, 0.018, 0.04)
TOLERANCE = 1e-9


def test_x_knots_and_periodicity() -> None:
    """(8), and (9) for the whole motion."""
    spline, mean = hip_x(P, CHOICE.x_sd, CHOICE.x_ed), P.D_s / P.T_c
    positions = [spline.at(t).position + mean * t for t in (0.0, P.T_d, P.T_c)]
    assert positions == pytest.approx([CHOICE.x_ed, P.D_s - CHOICE.x_sd, P.D_s + CHOICE.x_ed], abs=TOLERANCE)
    begin, end = spline.at(0.0), spline.at(P.T_c)
    assert end.velocity == pytest.approx(begin.velocity, abs=TOLERANCE)
    assert end.acceleration == pytest.approx(begin.acceleration, abs=TOLERANCE)


def test_closed_form() -> None:
    """(10) with its bracket in place and the coefficient that gives a continuous velocity."""
    T_c, T_d, D_s, (x_sd, x_ed, _, _) = P.T_c, P.T_d, P.D_s, CHOICE
    numerator = D_s * (T_c - T_d) / T_c - x_sd - x_ed
    t = np.linspace(0.0, T_d, 21)
    bracket = (T_d - t) ** 3 - t**3 - T_d**2 * (T_d - t) + T_d**2 * t
    first = numerator / (T_d**2 * (T_c - T_d)) * bracket + x_ed * (T_d - t) / T_d + (D_s - x_sd) * t / T_d
    found = hip_x(P, x_sd, x_ed).sample(t)[0] + D_s / T_c * t
    assert found == pytest.approx(first, abs=TOLERANCE)
    t, rest = np.linspace(T_d, T_c, 21), T_c - T_d
    bracket = (t - T_d) ** 3 - (T_c - t) ** 3 + rest**2 * (T_c - t) - rest**2 * (t - T_d)
    second = (
        numerator / (T_d * rest**2) * bracket
        + (D_s - x_sd) * (T_c - t) / rest
        + (D_s + x_ed) * (t - T_d) / rest
    )
    assert hip_x(P, x_sd, x_ed).sample(t)[0] + D_s / T_c * t == pytest.approx(second, abs=TOLERANCE)


def test_z_knots() -> None:
    """(7) with the middle of single support at (T_c + T_d) / 2."""
    spline = hip_z(P)
    middle = 0.5 * P.T_d, 0.5 * (P.T_c + P.T_d), P.T_c + 0.5 * P.T_d
    assert [spline.at(t).position for t in middle] == pytest.approx([P.H_min, P.H_max, P.H_min], abs=TOLERANCE)
    assert spline.at(middle[0]).acceleration == pytest.approx(spline.at(middle[2]).acceleration, abs=TOLERANCE)


def test_samples_are_linear_in_the_choice() -> None:
    times = np.arange(0.0, P.T_c, 0.01)
    x = sample_x(P, times).at(np.array([CHOICE.x_sd]), np.array([CHOICE.x_ed]))
    spline = hip_x(P, CHOICE.x_sd, CHOICE.x_ed).sample(times)
    assert x.position[:, 0] == pytest.approx(spline[0] + P.D_s / P.T_c * times, abs=TOLERANCE)
    assert x.acceleration[:, 0] == pytest.approx(spline[2], abs=1e-8)
    y = sample_y(P, times).at(np.array([CHOICE.y_d]), np.array([CHOICE.y_m]))
    assert y.velocity[:, 0] == pytest.approx(hip_y(P, CHOICE.y_d, CHOICE.y_m).sample(times)[1], abs=1e-8)


def test_ends_of_cycle() -> None:
    x, y = ends_of_cycle(P, CHOICE)
    assert x.position == pytest.approx(CHOICE.x_ed, abs=TOLERANCE)
    assert y.position == pytest.approx(-CHOICE.y_d, abs=TOLERANCE)
    step = 1e-5
    spline, mean = hip_x(P, CHOICE.x_sd, CHOICE.x_ed), P.D_s / P.T_c
    assert x.velocity == pytest.approx(
        mean + (spline.at(step).position - spline.at(0.0).position) / step, abs=1e-3
    )
