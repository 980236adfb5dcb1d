"""The thesis' torso design against its numbers (4.12)-(4.22), other plants, and closed forms of its figures."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest

from bridge.errors import ConfigurationError
from nao_hil.design.torso.analysis import margins, step_response
from nao_hil.design.torso.thesis import DYNAMIC_GAIT, STATIC_GAIT, thesis_design
from nao_hil.design.torso.transfer import denominator, numerator, thesis_plant, to_q, zero_order_hold
from tests.plants import second_order_plant
from walker.mechanisms.torso_control import ThesisSpecification

BRISK = ThesisSpecification(rise_time=0.4)
DENOMINATOR_Z = [1.0, -2.91467, 2.83405, -0.91937]


@pytest.fixture(scope="module")
def static():
    return thesis_design(thesis_plant(), STATIC_GAIT)


@pytest.fixture(scope="module")
def dynamic():
    return thesis_design(thesis_plant(), DYNAMIC_GAIT)


def test_sampled_plant(static) -> None:
    assert numerator(static.plant_z) == pytest.approx([-0.05833, 0.06319], rel=2e-4)
    # (4.13) prints 1.981 and 0.9861: half a unit of the last digit.
    assert denominator(static.plant_z) == pytest.approx([1.0, -1.981, 0.9861], abs=5e-4)
    assert float(np.real(static.plant_z.dcgain())) == pytest.approx(1.0, rel=1e-9)


def test_plant_in_the_q_domain(static) -> None:
    assert numerator(static.plant_q) == pytest.approx([0.000625, -0.12994, 1.0], rel=1e-3)
    assert denominator(static.plant_q) == pytest.approx([0.020394, 0.028582, 1.0], rel=1e-4)


def test_static_controller(static) -> None:
    assert static.pi.T_i == pytest.approx(0.0881, rel=0.005)
    assert static.pi.V_i == pytest.approx(1.983, rel=0.001)
    # (4.17) as printed, to its own digits
    assert numerator(static.controller_q) == pytest.approx([0.0035, 0.041, 0.184, 1.983], rel=0.025)
    assert denominator(static.controller_q)[:3] == pytest.approx([0.0203, 0.171, 1.0], rel=0.006)
    assert static.numerator_z == pytest.approx([0.17738, -0.51181, 0.49248, -0.15796], rel=0.005)
    assert static.denominator_z == pytest.approx(DENOMINATOR_Z, rel=5e-5)


def test_dynamic_controller(dynamic) -> None:
    assert dynamic.pi.T_i == pytest.approx(0.342, rel=0.01)
    assert dynamic.pi.V_i == pytest.approx(2.074, rel=0.01)
    assert numerator(dynamic.controller_q) == pytest.approx([0.01448, 0.04569, 0.7201, 2.075], rel=0.01)
    assert dynamic.numerator_z == pytest.approx([0.69147, -2.04949, 2.02810, -0.66998], rel=0.005)
    assert dynamic.denominator_z == pytest.approx(DENOMINATOR_Z, rel=5e-5)


def test_margins(static, dynamic) -> None:
    assert static.margins.phase_margin_deg == pytest.approx(60.0, abs=0.05)
    assert static.margins.crossover == pytest.approx(2.13, rel=0.005)
    assert static.margins.gain_margin == pytest.approx(2.13, rel=0.005)
    assert dynamic.margins.phase_margin_deg == pytest.approx(60.3, rel=0.01)
    assert dynamic.margins.crossover == pytest.approx(4.13, rel=0.005)
    assert dynamic.margins.gain_margin == pytest.approx(1.52, rel=0.01)


def test_step_responses(static, dynamic) -> None:
    assert static.stable and dynamic.stable
    assert static.step.overshoot == pytest.approx(0.137, rel=0.01)
    assert static.step.settling_time == pytest.approx(2.4, rel=0.025)
    assert dynamic.step.overshoot == pytest.approx(0.165, rel=0.01)
    assert dynamic.step.settling_time == pytest.approx(8.0, rel=0.01)
    for design in (static, dynamic):
        assert design.step.output[-1] == pytest.approx(1.0, abs=1e-3)
        assert design.step.output.min() < 0.0  # the zero in the right half plane


def test_q_domain_is_the_unit_circle() -> None:
    """G#(j (2/T) tan(omega T/2)) = G(exp(j omega T)) at any frequency below half the sampling rate."""
    plant_z = zero_order_hold(thesis_plant())
    for omega in (0.1, 7.0, 50.0, 300.0):
        image = to_q(plant_z)(1j * 200.0 * np.tan(omega * 0.005))
        assert image == pytest.approx(plant_z(np.exp(1j * omega * 0.01)), rel=1e-7)


@pytest.mark.parametrize(
    ("plant", "specification"),
    [
        (second_order_plant(9.0, 0.25, 15.0), ThesisSpecification(rise_time=0.5, overshoot=0.10)),
        (second_order_plant(7.0, 0.1, 8.0, gain=0.8), ThesisSpecification(rise_time=0.6, overshoot=0.05)),
        (control.tf([1.0], [0.01, 0.25, 1.0]), BRISK),  # no resonance: no notch
        (control.tf([1.0], [0.3, 1.0]), BRISK),
        (control.tf([1.0], np.convolve([0.02, 0.03, 1.0], [0.05, 1.0])), ThesisSpecification(rise_time=0.6)),
    ],
)
def test_any_plant_gets_its_margin_at_its_crossover(plant, specification) -> None:
    design = thesis_design(plant, specification)
    value = design.loop_q(1j * specification.crossover)
    assert abs(value) == pytest.approx(1.0, rel=1e-9)
    assert np.degrees(np.angle(value)) % 360.0 == pytest.approx(180.0 + specification.phase_margin_deg)
    assert design.stable
    assert design.step.output[-1] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    ("plant", "words"),
    [
        (second_order_plant(7.0, 0.1, 8.0, gain=-1.0), "steady-state gain"),
        (control.tf([1.0], [1.0, -1.0]), "stable"),
        (control.tf([1.0, 0.0, 0.0], [1.0, 1.0]), "degree"),
        (control.tf([0.1], [1.0, -0.9], 0.01), "continuous"),
    ],
)
def test_unfit_plants_are_refused(plant, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        thesis_design(plant, STATIC_GAIT)


@pytest.mark.parametrize("arguments", [(0.0, 0.1), (0.5, 10.0), (0.5, 0.1, 0.5), (float("nan"), 0.1)])
def test_senseless_specifications_are_refused(arguments) -> None:
    with pytest.raises(ConfigurationError):
        ThesisSpecification(**dict(zip(("rise_time", "overshoot", "notch_factor"), arguments, strict=False)))


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
