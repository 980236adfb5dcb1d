"""The thesis: its plant out of the mechanics, design values off plans, its claims on a nominal robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from bridge.body import BODIES, load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import CentreOfMass
from nao_hil.analysis.report.render import Outcome
from nao_hil.experiments.context import Context
from nao_hil.experiments.planned_walks import DT, EXPECTED, design_values, plan, read_plan
from nao_hil.experiments.spring import deflection
from nao_hil.experiments.torso_control import SWITCHES, drift_per_step
from nao_hil.experiments.torso_responses import THESIS, Plant, fit_plant, one_leg_stance, read_shape
from nao_hil.experiments.torso_step import TORSO_STEP
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk, WalkOutcome, walk
from walker.gaits import gait_parameters, make_gait
from walker.mechanisms.admittance import LegParameters

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


def torso_step(out: Path) -> Outcome:
    with Campaign(cluster="inline") as campaign:
        return TORSO_STEP.run("torso-step", Context(campaign, out, (0,), RunConfig()))


def test_the_nominal_robot_answers_like_the_thesis_plant(tmp_path: Path) -> None:
    result = torso_step(tmp_path).figures
    # (4.12): 7.0 rad/s, damping 0.10, zero 8 rad/s, gain 1, undershoot -0.30; rise 100 ms, peak 2.0.
    # About half to twice each: one seed says no more. Of five, zeros are 9.4 to 10 rad/s, and peaks 2.1 to 2.3.
    assert result["natural_frequency_rad_s"] == pytest.approx(7.0, rel=0.15)
    assert 0.05 < result["damping"] < 0.2
    assert 4.0 < result["zero_rad_s"] < 16.0
    assert result["gain"] == pytest.approx(1.0, abs=0.5)
    assert result["peak"] == pytest.approx(2.0, rel=0.3)
    assert -0.45 < result["undershoot"] < -0.15
    assert 0.05 < result["rise_time_s"] < 0.2
    assert result["residual_rms"] < 0.3  # the fused angle jumps where its filter switches
    assert (result["n"], result["fallen"]) == (3, 0)
    true = result["true"].natural_frequency_rad_s
    assert true == pytest.approx(result["natural_frequency_rad_s"], rel=0.1)
    assert (tmp_path / "torso-step.png").stat().st_size > 10_000


V3 = load_body("nao-v3")


def test_the_static_gait_is_read_as_it_was_asked_for() -> None:
    asked = {"T_DSP": 2.5, "T_SSP": 1.2, "l_lift": 0.03, "l_GH": 0.175}
    gait = make_gait("static", gait_parameters("static", asked), V3)
    assert design_values(plan(gait, 12.0), V3) == pytest.approx(asked, rel=1e-3)


def test_the_dynamic_gait_is_read_as_the_thesis_parameters_mean() -> None:
    thesis = {"e_s1": 0.03, "e_su": 0.0051, "S_a0": 0.04, "z": 0.23, "l_FA": 0.1}
    gait = make_gait("dynamic", gait_parameters("dynamic", thesis), V3)
    assert read_plan(plan(gait, 4.0, DT), DT) == pytest.approx(EXPECTED, rel=0.01)


def test_no_history_of_forces_reaches_the_pole() -> None:
    for seed in range(3):
        assert 0.5 < deflection(seed, LegParameters(), cycles=500) < 1.0


def test_without_torso_control_the_static_gait_pitches_further_with_every_step_until_it_falls() -> None:
    """Figure 4.9: with the admittances alone the robot falls after about 20 s; torso control holds it.

    Seven seeds without it all fall, and pitch by 1.3 to 7.6 deg per step; eight with it all stand, and drift by
    0.2 deg per step at most.
    """

    def walked(name: str, seed: int, seconds: float) -> WalkOutcome:
        controller = {"switches": SWITCHES[name]["controller.switches"]}
        config = RunConfig(robot="nao-v3", engine="mujoco", gait="static", seed=seed, controller=controller)
        return walk(Walk(name=name, config=config, duration=seconds))

    without = [walked("without", seed, 25.0) for seed in (500, 501)]
    assert not any(outcome.end.survived for outcome in without)
    growth = float(np.median([drift_per_step(outcome) or 0.0 for outcome in without]))
    assert growth > 1.0  # deg per step, forward
    with_ = walked("with", 500, 15.0)
    held = drift_per_step(with_)
    assert with_.end.survived and held is not None and abs(held) < 0.3 * growth
