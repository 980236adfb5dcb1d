"""Gear of the drives: backlash, twist, brake, dry friction."""

import math

import numpy as np
import pytest

from bridge.body import load_body
from emulator.drives import BRUSH_REACH
from emulator.servo.parameters import Backlash, ServoParameters
from emulator.servo.servo import Servo
from tests.servos import torques

STEP = 0.001
STALL, NO_LOAD = 7.785, 6.402
"""Printed joint-side figures of the V3's pitch joints: N m, rad/s."""
BACKLASH = math.radians(1.4)


def knee(parameters: ServoParameters, stiffness: float = 1.0, request: float = 0.5) -> Servo:
    servo = Servo(load_body("nao-v3"), ("LKneePitch",), parameters, np.array([0.5]), STEP)
    servo.latch((request,) * 25, (stiffness,) * 25)
    return servo


def hold(servo: Servo, angle: float, speed: float = 0.0, steps: int = 500) -> float:
    """Torque after a while at an angle, N m; with a speed, led up to it."""
    for k in reversed(range(steps)):
        torque = float(torques(servo, np.array([angle - k * STEP * speed]), np.array([speed]))[0])
    return torque


@pytest.mark.parametrize("compliance", [0.0, 0.008])
@pytest.mark.parametrize("backlash", [0.0, BACKLASH])
@pytest.mark.parametrize("off", [-0.08, -0.02, 0.005, 0.05])
def test_a_held_joint_feels_loop_and_gear_in_series_behind_the_play(
    off: float, backlash: float, compliance: float
) -> None:
    parameters = ServoParameters(
        full_voltage_error=0.11,
        gear_compliance=compliance,
        gear_relaxation=0.01,
        backlash=Backlash(KneePitch=backlash),
    )
    torque = hold(knee(parameters), 0.5 + off)
    beyond = max(abs(off) - 0.5 * backlash, 0.0)
    expected = -math.copysign(beyond, off) / (0.11 / STALL + compliance)
    assert torque == pytest.approx(expected, rel=2e-3, abs=1e-9)


def test_no_torque_inside_the_play_and_the_full_width_on_reversal() -> None:
    servo = knee(ServoParameters(backlash=Backlash(KneePitch=BACKLASH)))
    hold(servo, 0.5)
    inside = [hold(servo, 0.5 + way, steps=1) for way in np.linspace(-0.49, 0.49, 50) * BACKLASH]
    assert inside == [0.0] * 50
    assert hold(servo, 0.5 + 0.51 * BACKLASH) < 0.0 < hold(servo, 0.5 - 0.51 * BACKLASH)


def test_the_load_drives_a_weak_motor_back_with_its_limit() -> None:
    servo = knee(ServoParameters(), stiffness=0.1)
    assert hold(servo, 0.9, speed=1.0, steps=200) == pytest.approx(-0.1 * STALL, rel=2e-3)


@pytest.mark.parametrize(("stiffness", "speed", "brake"), [(0.0, 0.5, 0.5), (0.0, 5.0, 0.0), (-1.0, 0.5, 0.0)])
def test_stiffness_zero_brakes_like_a_short_circuit_and_negative_does_not(
    stiffness: float, speed: float, brake: float
) -> None:
    servo = knee(ServoParameters(brake=0.1), stiffness=stiffness, request=2.0)
    expected = -min(STALL / NO_LOAD * speed, 0.1 * STALL) if stiffness == 0.0 else 0.0
    assert hold(servo, 1.0, speed, steps=50) == pytest.approx(expected, rel=2e-3, abs=1e-12)
    assert hold(servo, 1.0) == pytest.approx(0.0, abs=1e-12)


INERTIA = 0.005
"""Of a joint, kg m^2."""


def limp(friction: float) -> Servo:
    """A knee whose motor gives nothing, at angle 0, with a rotor of `INERTIA`: only its gear brakes."""
    parameters = ServoParameters(dry_friction=friction, motor_time_constant=INERTIA * NO_LOAD / STALL)
    servo = Servo(load_body("nao-v3"), ("LKneePitch",), parameters, np.zeros(1), STEP)
    servo.latch((0.0,) * 25, (-1.0,) * 25)
    return servo


def slide(friction: float, drive: float, duration: float) -> tuple[float, float]:
    """Angle and speed of a joint of `INERTIA` after a constant torque from rest, as PyBullet integrates."""
    gear = limp(friction)
    angle, speed = np.zeros(1), np.zeros(1)
    for _ in range(round(duration / STEP)):
        torque = drive + torques(gear, angle, speed)
        speed += torque / INERTIA * STEP
        angle += speed * STEP
    return float(angle[0]), float(speed[0])


def test_friction_holds_what_is_below_it() -> None:
    angle, speed = slide(0.05, 0.045, 5.0)
    # a torque that comes at once swings a little way past the bend
    assert 0.0 < angle < 2.0 * BRUSH_REACH
    assert abs(speed) < 1e-6


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_friction_takes_its_amount_from_what_is_above_it(sign: float) -> None:
    _, speed = slide(0.05, sign * 0.15, 0.5)
    assert speed == pytest.approx(sign * (0.15 - 0.05) / INERTIA * 0.5, rel=0.02)


def test_friction_only_takes_energy() -> None:
    gear = limp(0.05)
    work = 0.0
    for k in range(20000):
        angle = 0.02 * math.sin(0.02 * k) + 0.0005 * math.sin(0.7 * k)
        speed = 0.02 * 20.0 * math.cos(0.02 * k) + 0.0005 * 700.0 * math.cos(0.7 * k)
        work -= float(torques(gear, np.array([angle]), np.array([speed]))[0]) * speed * STEP
        # the brush gives back at most what its bending holds
        assert work > -0.5 * 0.05 * BRUSH_REACH
    assert work > 0.0
