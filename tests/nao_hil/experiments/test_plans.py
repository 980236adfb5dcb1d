"""Design values read off planned trajectories, the spring, and the torso designs' figures."""

import math

import numpy as np
import pytest

from bridge.body import load_body
from nao_hil.experiments import torso_design
from nao_hil.experiments.planned_walks import DT, EXPECTED, design_values, plan, read_plan
from nao_hil.experiments.spring import deflection
from walker.gaits import gait_parameters, make_gait
from walker.mechanisms.admittance import LegParameters

V3 = load_body("nao-v3")


def test_the_static_gait_is_read_as_it_was_asked_for() -> None:
    asked = {"T_DSP": 2.5, "T_SSP": 1.2, "l_lift": 0.03, "l_GH": 0.175}
    gait = make_gait("static", gait_parameters("static", asked), V3)
    assert design_values(plan(gait, 12.0), V3) == pytest.approx(asked, rel=1e-3)


def test_the_dynamic_gait_is_read_as_the_thesis_parameters_mean() -> None:
    thesis = {"e_s1": 0.03, "e_su": 0.0051, "S_a0": 0.04, "z": 0.23, "l_FA": 0.1}
    gait = make_gait("dynamic", gait_parameters("dynamic", thesis), V3)
    assert read_plan(plan(gait, 4.0, DT), DT) == pytest.approx(EXPECTED, rel=0.01)


def test_another_step_is_read_as_another_step() -> None:
    gait = make_gait("dynamic", gait_parameters("dynamic", {"S_a0": 0.03}), V3)
    found = read_plan(plan(gait, 4.0, DT), DT)
    # the times depend on the sideways motion alone, the ways are proportional to S_a0
    assert found["step_time"] == pytest.approx(EXPECTED["step_time"], rel=0.01)
    assert found["step_length"] == pytest.approx(0.75 * EXPECTED["step_length"], rel=0.01)


def test_no_history_of_forces_reaches_the_pole() -> None:
    for seed in range(3):
        assert 0.5 < deflection(seed, LegParameters(), cycles=500) < 1.0


def test_a_polynomial_is_as_far_off_as_its_worst_coefficient() -> None:
    assert torso_design.off(1.02, 1.0) == pytest.approx(0.02)
    assert torso_design.off((1.0, -2.0), (1.0, -2.5)) == pytest.approx(0.2)
    assert math.isinf(torso_design.off((1.0,), (1.0, 2.0)))
    assert np.isfinite(torso_design.off((0.5,), (1.0,)))
