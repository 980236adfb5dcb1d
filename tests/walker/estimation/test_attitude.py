"""Roll and pitch of the torso: the fused angle without its drift, and the lean by the gyroscope."""

from __future__ import annotations

import math

import pytest
from scipy.spatial.transform import Rotation

from bridge.messages import SensorFrame
from tests.frames import standing_frame
from walker.estimation.attitude import Attitude, AttitudeParameters, Lean, LeanParameters

DT = 0.001
LATENCY = 0.04
ALONE = LeanParameters(time_constant=1e9)


@pytest.mark.parametrize("turn", [0.0, 1.5])
def test_integral_is_the_orientation_of_a_body_that_rotates_and_turns(turn):
    """The body rate of a known motion, by finite differences of its rotation matrix, gives its angles back."""

    def orientation(t):
        angles = [turn * t, 0.15 * math.sin(4.0 * t), 0.2 * math.sin(3.0 * t)]
        return Rotation.from_euler("ZYX", angles)

    lean = Lean(ALONE, LATENCY)
    lean.angle = (0.0, 0.0)
    for k in range(1000):
        t = k * DT
        x, y, z = (orientation(t).inv() * orientation(t + DT)).as_rotvec() / DT
        lean.update((x, y, z), (9.9, 9.9), turn, DT)
    _, pitch, roll = orientation(1.0).as_euler("ZYX")
    assert lean.angle == pytest.approx((roll, pitch), abs=2e-3)


def test_a_lean_that_stays_is_the_grounds():
    lean = Lean(LeanParameters(mean_time_constant=0.5), LATENCY)
    for _ in range(4000):
        lean.update((0.0, 0.0, 0.0), (0.1, -0.1), 0.0, DT)
    assert lean.angle == pytest.approx((0.1, -0.1))
    assert lean.lean_without_mean == pytest.approx((0.0, 0.0), abs=1e-3)


def test_bias_of_the_gyroscope_leaves_bias_times_time_constant():
    lean = Lean(LeanParameters(time_constant=0.5), LATENCY)
    for _ in range(8000):
        lean.update((0.02, -0.02, 0.0), (0.1, 0.0), 0.0, DT)
    assert lean.angle == pytest.approx((0.1 + 0.01, -0.01), abs=1e-4)


DT_ATTITUDE = 0.01


def imu(seq: int, fused: float, pitch: float, shock: float) -> SensorFrame:
    """A torso at `pitch` whose fused angle is wrong, shaken along x as a walk does: no net speed."""
    g = 9.81
    return standing_frame(
        seq,
        time=seq * DT_ATTITUDE,
        accelerometer=(-g * math.sin(pitch) + shock, 0.0, g * math.cos(pitch)),
        angle=(0.0, fused),
    )


def test_attitude_takes_the_drift_out_of_the_fused_angle() -> None:
    """The fused angle runs away by 0.3 deg/s; the torso stands at 2 deg and is shaken with 3 m/s^2 at 2 Hz."""
    attitude = Attitude(AttitudeParameters())
    true, drift = math.radians(2.0), math.radians(0.3)
    errors = []
    for k in range(6000):
        shock = 3.0 * math.sin(4.0 * math.pi * k * DT_ATTITUDE)
        _, pitch = attitude.update(imu(k, true + drift * k * DT_ATTITUDE, true, shock), DT_ATTITUDE)
        if k > 4000:
            errors.append(pitch - true)
    assert max(map(abs, errors)) < math.radians(1.0)
    assert abs(sum(errors) / len(errors)) < math.radians(0.2)
