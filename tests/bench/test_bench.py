"""Figures of the benchmarks against closed forms."""

from __future__ import annotations

import pytest

from bridge.body import load_body
from emulator.servo.parameters import Backlash, ServoParameters
from tests.bench.identification import CALIBRATION, VALIDATION, Recovered, summary, true_value


def test_errors_beyond_the_scatter_are_the_models() -> None:
    """Variances add: errors of 5 with a scatter of 3 leave 4."""
    recovered = [
        Recovered("delay", error=5.0, scatter=3.0, held=True),
        Recovered("delay", error=-5.0, scatter=3.0, held=False),
        Recovered("stiffness", error=0.1, scatter=None, held=True),
    ]
    found = summary(recovered)
    assert found["delay"] == {"n": 2, "largest_error": 5.0, "rms_error": 5.0, "held": 1, "model_error": 4.0}
    assert found["stiffness"]["n"] == found["stiffness"]["held"] == 1
    assert found["stiffness"]["model_error"] is None


def test_the_true_stiffness_is_that_of_loop_and_gear_in_series() -> None:
    """Stall torque of the V3's knee: 7.786 N m. HipYawPitch: one motor, two gears side by side."""
    drives = ServoParameters(
        full_voltage_error=0.09,
        gear_compliance=0.010,
        delay=0.03,
        backlash=Backlash(HeadYaw=0.02, KneePitch=0.01),
    )
    body = load_body("nao-v3")
    knee = true_value(body, drives, "stiffness.KneePitch")
    assert knee == pytest.approx(1.0 / (0.09 / 7.786 + 0.010), rel=1e-3)
    gears = 1.0 / true_value(body, drives, "stiffness.HipYawPitch")
    loop = gears - 0.005
    assert loop == pytest.approx(1.0 / true_value(body, drives, "stiffness.HipRoll") - 0.010, rel=1e-6)
    assert true_value(body, drives, "backlash.KneePitch") == 0.01
    assert true_value(body, drives, "backlash.HeadYaw") == 0.02
    assert true_value(body, drives, "delay") == 0.03


def test_no_robot_is_both_calibrated_on_and_tested() -> None:
    assert not set(CALIBRATION) & set(VALIDATION)
