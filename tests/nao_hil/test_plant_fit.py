"""The fit of the torso's plant, against (4.12) and scipy's own simulation."""

import numpy as np
import pytest
from scipy import signal

from nao_hil.experiments.torso_responses import THESIS, Plant, fit_plant, read_shape

TIME = np.arange(0.01, 4.001, 0.01)


@pytest.mark.parametrize(
    "plant", [THESIS, Plant(gain=-1.4, natural_frequency_rad_s=5.0, damping=0.4, zero_time_s=-0.02)]
)
def test_the_closed_form_is_the_transfer_functions_step(plant: Plant) -> None:
    w = plant.natural_frequency_rad_s
    system = signal.lti(
        [-plant.gain * plant.zero_time_s, plant.gain], [1.0 / w**2, 2.0 * plant.damping / w, 1.0]
    )
    fine = np.arange(0.0, 4.001, 0.001)
    _, expected = signal.step(system, T=fine)
    np.testing.assert_allclose(plant.step(fine)[1:], expected[1:], atol=1e-9)


def test_the_thesis_curve_has_the_printed_figures() -> None:
    fine = np.arange(0.001, 20.0, 0.001)
    shape = read_shape(fine, THESIS.step(fine))
    assert THESIS.natural_frequency_rad_s == pytest.approx(7.0, abs=0.01)
    assert THESIS.damping == pytest.approx(0.10, abs=0.001)
    assert shape.peak == pytest.approx(1.95, abs=0.01)
    assert shape.rise_time_s == pytest.approx(0.108, abs=0.002)
    assert shape.undershoot < -0.2


def test_the_fit_finds_a_plant_in_noise() -> None:
    true = Plant(gain=1.3, natural_frequency_rad_s=8.2, damping=0.22, zero_time_s=0.05)
    noise = np.random.default_rng(0).normal(0.0, 0.02, len(TIME))
    plant, residual = fit_plant(TIME, true.step(TIME) + noise)
    for field in Plant.__struct_fields__:
        assert getattr(plant, field) == pytest.approx(getattr(true, field), rel=0.03, abs=0.003)
    assert residual == pytest.approx(0.02, rel=0.1)
