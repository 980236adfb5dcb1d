"""The robust torso design: what it promises, at the corners and inside, and that it refuses the rest."""

from __future__ import annotations

import itertools

import control
import numpy as np
import pytest

from bridge.errors import ConfigurationError
from nao_hil.design.torso.robust import corners, perturbations, robust_design, worst_case
from nao_hil.design.torso.thesis import DYNAMIC_GAIT, STATIC_GAIT, thesis_design
from nao_hil.design.torso.transfer import thesis_plant
from tests.plants import second_order_plant
from walker.mechanisms.torso_control import RobustSpecification


@pytest.fixture(scope="module")
def robust():
    return robust_design(thesis_plant())


def test_bounds_hold_on_the_identified_plant(robust) -> None:
    assert robust.stable
    assert robust.step.overshoot < 0.10
    assert robust.margins.gain_margin >= 2.5
    assert robust.numerator_z[0] <= 0.174 * 1.01  # (4.19), the noise bound


def test_bounds_hold_everywhere_in_the_uncertainty(robust) -> None:
    """On a grid, edges and interior; poles and step responses by `control` on plants built by hand."""
    for frequency, damping, zero in itertools.product((0.8, 1.0, 1.2), repeat=3):
        plant = second_order_plant(
            frequency / np.sqrt(0.02041), damping * 0.02857 / 2.0 / np.sqrt(0.02041), 8.0 * zero
        )
        sampled = control.sample_system(plant, 0.01, method="zoh")
        loop = robust.controller_z * sampled
        closed = control.feedback(loop, 1)
        assert np.abs(closed.poles()).max() < 1.0
        response = control.step_response(closed, T=np.arange(0.0, 6.0, 0.01)).outputs
        assert response.max() < 1.10
        for factor in np.geomspace(1.0 / 2.5, 2.5, 9):
            assert np.abs(control.feedback(factor * loop, 1).poles()).max() < 1.0


def test_the_thesis_designs_do_not_keep_these_bounds(robust) -> None:
    plants = corners(thesis_plant(), 0.2)
    good = worst_case(robust, plants)
    assert good.stable and good.overshoot < 0.10 and good.gain_margin >= 2.5
    for specification in (STATIC_GAIT, DYNAMIC_GAIT):
        design = thesis_design(thesis_plant(), specification)
        bad = worst_case(design, plants)
        assert bad.overshoot > 0.10 and bad.gain_margin < 2.5
        assert robust.step.rise_time > design.step.rise_time  # the price


@pytest.mark.parametrize(
    "plant",
    [
        second_order_plant(9.0, 0.3, 20.0),
        second_order_plant(5.5, 0.15, 10.0, gain=0.9),
        control.tf([1.0], [0.2, 1.0]),
    ],
)
def test_other_plants(plant) -> None:
    specification = RobustSpecification()
    design = robust_design(plant, specification)
    worst = worst_case(design, perturbations(plant, (0.8, 1.0, 1.2)))
    assert worst.stable and worst.overshoot <= 0.10 and worst.gain_margin >= 2.5
    assert design.step.output[-1] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    "arguments", [{"overshoot": 0.0}, {"gain_margin": 1.0}, {"noise_gain": 0.0}, {"spread": 1.0}]
)
def test_senseless_specifications_are_refused(arguments) -> None:
    with pytest.raises(ConfigurationError):
        robust_design(thesis_plant(), RobustSpecification(**arguments))
