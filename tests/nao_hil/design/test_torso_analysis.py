"""Margins, step figures and diagrams against closed forms."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest

from nao_hil.design.torso.analysis import bode, frequency_response, margins, step_response
from nao_hil.design.torso.transfer import thesis_plant


def test_margins_of_a_triple_lag() -> None:
    """K/(1+s)^3 has a gain margin of 8/K."""
    result = margins(control.tf([2.0], [1.0, 3.0, 3.0, 1.0]))
    assert result.gain_margin == pytest.approx(4.0, rel=1e-6)
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
    reference = control.step_info(
        control.tf([omega**2], [1.0, 2.0 * damping * omega, omega**2]), T=np.arange(0, 8, 1e-3)
    )
    assert step.rise_time == pytest.approx(reference["RiseTime"], abs=0.003)
    assert step.settling_time == pytest.approx(reference["SettlingTime"], abs=0.003)


def test_step_figures_of_an_unstable_loop_are_infinite() -> None:
    step = step_response(control.tf([-0.1], [1.0, -1.1], 0.01))
    assert step.overshoot == step.settling_time == step.rise_time == math.inf


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
