"""Margins, step figures and Nyquist's criterion against closed forms and closed-loop poles."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from walker.torso.analysis import bode, frequency_response, margins, nyquist_count, step_response
from walker.torso.design import DYNAMIC_GAIT, STATIC_GAIT, thesis_design
from walker.torso.transfer import thesis_plant


def test_margins_of_a_triple_lag() -> None:
    """K/(1+s)^3 has a gain margin of 8/K at sqrt(3) rad/s."""
    result = margins(control.tf([2.0], [1.0, 3.0, 3.0, 1.0]))
    assert result.gain_margin == pytest.approx(4.0, rel=1e-6)
    assert result.phase_crossover == pytest.approx(math.sqrt(3.0), rel=1e-6)
    crossover = math.sqrt(2.0 ** (2.0 / 3.0) - 1.0)
    assert result.crossover == pytest.approx(crossover, rel=1e-6)
    assert result.phase_margin_deg == pytest.approx(180.0 - 3.0 * math.degrees(math.atan(crossover)), rel=1e-6)


def test_step_figures_of_a_second_order_loop() -> None:
    damping, omega = 0.4, 3.0
    closed = control.sample_system(
        control.tf([omega**2], [1.0, 2.0 * damping * omega, omega**2]), 0.001, method="zoh"
    )
    step = step_response(closed)
    assert step.overshoot == pytest.approx(math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2)), rel=1e-4)
    assert step.undershoot == 0.0
    reference = control.step_info(
        control.tf([omega**2], [1.0, 2.0 * damping * omega, omega**2]), T=np.arange(0, 8, 1e-3)
    )
    assert step.rise_time == pytest.approx(reference["RiseTime"], abs=0.003)
    assert step.settling_time == pytest.approx(reference["SettlingTime"], abs=0.003)


def test_step_figures_of_an_unstable_loop_are_infinite() -> None:
    step = step_response(control.tf([-0.1], [1.0, -1.1], 0.01))
    assert step.overshoot == step.settling_time == step.rise_time == math.inf


@pytest.mark.parametrize("specification", [STATIC_GAIT, DYNAMIC_GAIT])
def test_nyquist_count_of_the_thesis_loops(specification) -> None:
    """(4.18) with max(deg z_L, deg n_L) = 5 and N_- = 4: the angle must change by pi, and does."""
    count = nyquist_count(thesis_design(thesis_plant(), specification).loop_q)
    assert count.required == pytest.approx(math.pi)
    assert count.angle_change == pytest.approx(math.pi, abs=1e-3)
    assert count.stable


@pytest.mark.parametrize("specification", [STATIC_GAIT, DYNAMIC_GAIT])
@pytest.mark.parametrize("share", [0.98, 1.02])
def test_nyquist_count_sees_the_gain_margin(specification, share: float) -> None:
    design = thesis_design(thesis_plant(), specification)
    count = nyquist_count(share * design.margins.gain_margin * design.loop_q)
    assert count.stable is (share < 1.0)


roots = st.lists(
    st.one_of(
        st.floats(0.1, 10.0).map(lambda size: [1.0, size]),
        st.floats(0.1, 10.0).map(lambda size: [1.0, -size]),
        st.tuples(st.floats(0.1, 10.0), st.floats(-0.9, 0.9).filter(lambda d: abs(d) > 0.05)).map(
            lambda pair: [1.0, 2.0 * pair[1] * pair[0], pair[0] ** 2]
        ),
    ),
    min_size=1,
    max_size=3,
)


@settings(max_examples=150, deadline=None)
@given(
    roots,
    st.lists(st.floats(-10.0, 10.0).filter(lambda z: abs(z) > 0.1), max_size=2),
    st.floats(0.1, 50.0),
    st.booleans(),
)
def test_nyquist_count_agrees_with_the_closed_loop_poles(factors, zeros, gain: float, integrator: bool) -> None:
    """Poles left and right, with and without one at the origin; loops at the border are left out."""
    bottom = np.array([1.0, 0.0]) if integrator else np.array([1.0])
    for factor in factors:
        bottom = np.convolve(bottom, factor)
    top = gain * np.poly(zeros[: len(bottom) - 1])
    closed = np.polyadd(bottom, top)
    if abs(closed[0]) < 1e-3 * abs(bottom[0]):
        return
    poles = np.roots(closed)
    if np.abs(poles.real).min() < 1e-3:
        return
    assert nyquist_count(control.tf(top, bottom)).stable is bool(poles.real.max() < 0.0)


def test_bode_of_an_integrator_with_lag() -> None:
    omega = np.array([0.01, 1.0, 100.0])
    diagram = bode(control.tf([1.0], [1.0, 1.0, 0.0]), omega)
    expected = 1.0 / (1j * omega * (1.0 + 1j * omega))
    assert diagram.magnitude_db == pytest.approx(20.0 * np.log10(np.abs(expected)))
    assert diagram.phase_deg == pytest.approx(-90.0 - np.degrees(np.arctan(omega)))


def test_frequency_response_agrees_with_control() -> None:
    plant = thesis_plant()
    omega = np.geomspace(0.1, 100.0, 20)
    assert frequency_response(plant, omega) == pytest.approx(plant(1j * omega))
