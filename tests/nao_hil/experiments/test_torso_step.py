"""The identification experiment: the thesis' plant comes out of the mechanics."""

from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from bridge.body import BODIES, load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import CentreOfMass
from bridge.errors import ConfigurationError
from nao_hil.experiments.torso_responses import THESIS, Plant, fit_plant, one_leg_stance, read_shape
from nao_hil.experiments.torso_step import run

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


@pytest.mark.parametrize("name", BODIES)
def test_the_stance_is_upright_over_the_left_foot(name: str) -> None:
    body = load_body(name)
    angles = one_leg_stance(body)
    com = CentreOfMass(body)
    feet = com.tree.link_frames(angles)
    left, right = feet["LAnkleRoll"], feet["RAnkleRoll"]
    np.testing.assert_allclose(left[:3, :3], np.eye(3), atol=1e-9)
    np.testing.assert_allclose((com(angles) - left[:3, 3])[:2], body.foot.centre, atol=1e-4)
    assert right[2, 3] - left[2, 3] > 0.03
    assert angles[INDEX["LKneePitch"]] == 0.0


def test_the_nominal_robot_answers_like_the_thesis_plant(tmp_path: Path) -> None:
    result = run([0], out=tmp_path)
    # (4.12): 7.0 rad/s, damping 0.10, zero 8 rad/s, gain 1, undershoot -0.30; rise 100 ms
    assert result["natural_frequency_rad_s"] == pytest.approx(7.0, rel=0.15)
    assert 0.07 < result["damping"] < 0.15
    assert result["zero_rad_s"] == pytest.approx(8.0, rel=0.25)
    assert result["gain"] == pytest.approx(1.0, abs=0.25)
    assert result["peak"] == pytest.approx(2.0, rel=0.1)  # as read off figure 4.10
    assert result["undershoot"] == pytest.approx(-0.30, abs=0.08)
    assert result["rise_time_s"] == pytest.approx(0.100, rel=0.25)
    assert result["residual_rms"] < 0.2  # the fused angle jumps where its filter switches
    assert (result["n"], result["fallen"]) == (3, 0)
    true = result["true"].natural_frequency_rad_s
    assert true == pytest.approx(result["natural_frequency_rad_s"], rel=0.05)
    assert (tmp_path / "torso-step.png").stat().st_size > 10_000


def test_a_wave_that_throws_the_robot_over_is_one_clear_sentence() -> None:
    with pytest.raises(ConfigurationError, match="No stance on one leg survived a wave of 15 deg"):
        run([0], amplitude=0.2618)
