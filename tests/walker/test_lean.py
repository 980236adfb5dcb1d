"""The torso's lean by the gyroscope: kinematics of a rotating body, and its prediction."""

from __future__ import annotations

import math

import pytest
from scipy.spatial.transform import Rotation

from walker.estimation.attitude import Lean, LeanParameters

DT = 0.001
ALONE = LeanParameters(time_constant=1e9, latency=0.04)


@pytest.mark.parametrize("turn", [0.0, 1.5])
def test_integral_is_the_orientation_of_a_body_that_rotates_and_turns(turn):
    """The body rate of a known motion, by finite differences of its rotation matrix, gives its angles back."""

    def orientation(t):
        angles = [turn * t, 0.15 * math.sin(4.0 * t), 0.2 * math.sin(3.0 * t)]
        return Rotation.from_euler("ZYX", angles)

    lean = Lean(ALONE)
    lean.angle = (0.0, 0.0)
    for k in range(1000):
        t = k * DT
        x, y, z = (orientation(t).inv() * orientation(t + DT)).as_rotvec() / DT
        lean.update((x, y, z), (9.9, 9.9), turn, DT)
    _, pitch, roll = orientation(1.0).as_euler("ZYX")
    assert lean.angle == pytest.approx((roll, pitch), abs=2e-3)


def test_a_constant_rate_is_extrapolated_over_the_latency():
    lean = Lean(LeanParameters(time_constant=1e9, mean_time_constant=1e9, latency=0.04))
    for _ in range(100):
        lean.update((0.5, 0.0, 0.0), (0.0, 0.0), 0.0, DT)
    assert lean.swing == pytest.approx((0.5 * (0.04 + 99 * DT), 0.0), rel=1e-3)


def test_a_lean_that_stays_is_the_grounds():
    lean = Lean(LeanParameters(mean_time_constant=0.5))
    for _ in range(4000):
        lean.update((0.0, 0.0, 0.0), (0.1, -0.1), 0.0, DT)
    assert lean.angle == pytest.approx((0.1, -0.1))
    assert lean.swing == pytest.approx((0.0, 0.0), abs=1e-3)


def test_bias_of_the_gyroscope_leaves_bias_times_time_constant():
    lean = Lean(LeanParameters(time_constant=0.5))
    for _ in range(8000):
        lean.update((0.02, -0.02, 0.0), (0.1, 0.0), 0.0, DT)
    assert lean.angle == pytest.approx((0.1 + 0.01, -0.01), abs=1e-4)
