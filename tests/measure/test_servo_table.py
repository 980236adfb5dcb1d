"""The bench of the drives."""

import math

import numpy as np
import pytest

from bridge.body import load_body
from emulator.wear import load_wear
from nao_hil.experiments import servo_bench
from nao_hil.experiments.servo_bench import LEGS, cruise_speed, motion_times, part
from tests.measure.servo_table import fall_limp, overload

V3, NOMINAL = load_body("nao-v3"), load_wear("nominal")


# printed: 238 deg/s behind gear 201.3, 367 deg/s behind 130.85
@pytest.mark.parametrize(
    ("joint", "speed"),
    [
        ("LHipYawPitch", 238),
        ("RHipRoll", 238),
        ("LAnkleRoll", 238),
        ("LHipPitch", 367),
        ("RKneePitch", 367),
        ("LAnklePitch", 367),
    ],
)
def test_no_load_speed(joint: str, speed: float, physics: str) -> None:
    track = servo_bench.run_through(V3, NOMINAL, physics, joint)
    measured = cruise_speed(track[:, 0], part(track, 1)[:, LEGS.index(joint)])
    assert math.degrees(measured) == pytest.approx(speed, rel=0.05)


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
@pytest.mark.parametrize("joint", ["LKneePitch", "LAnkleRoll"])
def test_motion_begins_within_two_cycles_of_the_dead_time(name: str, joint: str, physics: str) -> None:
    """36 to 57 ms are published by definitions that include the drive's lag: the first motion is earlier."""
    body = load_body(name)
    step = math.radians(10.0)
    nominal = load_wear("nominal", body)
    track = servo_bench.step_response(body, nominal, physics, joint, step)
    begin = motion_times(body, track, LEGS.index(joint), step)[0]
    assert nominal.servo.delay < begin <= nominal.servo.delay + 2.0 * body.cycle
    assert begin < 0.057


@pytest.mark.parametrize("wear", ["nominal", "worn"])
def test_the_loop_is_as_wide_as_the_play(wear: str, physics: str) -> None:
    profile = load_wear(wear)
    track = servo_bench.slow_reversal(V3, profile, physics, math.radians(5.0), math.radians(4.0))
    width = np.ptp(part(track, 2) - part(track, 1), axis=0)
    np.testing.assert_allclose(width, [profile.servo.backlash.of(joint) for joint in LEGS], rtol=0.1)


def test_half_the_stiffness_is_half_the_torque_and_none_is_none(physics: str) -> None:
    (full, ampere), (half, _), (none, idle) = (
        servo_bench.clamped(V3, NOMINAL, physics, s) for s in (1.0, 0.5, 0.0)
    )
    printed = [11.97 if joint.endswith(("YawPitch", "Roll")) else 7.78 for joint in LEGS]
    np.testing.assert_allclose(full, printed, rtol=0.02)
    np.testing.assert_allclose(half, full / 2.0, rtol=0.01)
    np.testing.assert_allclose(none, 0.0, atol=1e-6)
    # stall torque 59.5 mN m over 21.6 V per 8000 rpm
    np.testing.assert_allclose(ampere, 59.5e-3 * 837.76 / 21.6, rtol=0.01)
    np.testing.assert_allclose(idle, 0.0, atol=1e-6)


def test_without_stiffness_hips_and_knees_fall_by_their_weight(physics: str) -> None:
    fallen = dict(zip(LEGS, np.degrees(fall_limp(V3, NOMINAL, physics)), strict=True))
    assert min(fallen[side + joint] for side in "LR" for joint in ("HipRoll", "HipPitch", "KneePitch")) > 15.0


def test_a_stalled_motor_warms_as_the_closed_form_says_and_is_derated() -> None:
    track = overload(V3, NOMINAL, "mujoco", 16.0)
    hot = part(track, 4) > 85.0
    warm = [float(track[int(np.argmax(hot[:, i])), 0] - track[0, 0]) for i in range(len(LEGS))]
    rise = 60.0 * (59.5 / 12.3) ** 2
    np.testing.assert_allclose(warm, -300.0 * math.log(1.0 - 60.0 / rise), rtol=0.03)
    assert (part(track, 5)[-1] < 0.7).all()
    np.testing.assert_allclose(part(track, 5)[0], 1.0)
