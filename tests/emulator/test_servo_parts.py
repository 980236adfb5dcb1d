"""Parts of a servo: limits of requests, heat, gear."""

import math

import numpy as np
import pytest

from bridge.body import BODIES, joint_tree, load_body
from bridge.body.joints import INDEX
from bridge.body.quantities import COUPLED_TO, coupled_limits
from emulator.drives import BRUSH_REACH
from emulator.robot import EmulatedRobot
from emulator.servo.parameters import Backlash, Heating, ServoParameters
from emulator.servo.servo import MotorHeat, RequestLimits, Servo, stiffness_factor
from emulator.wear import load_wear
from tests.servos import torques

HEATING = Heating(rise=60.0, time_constant=300.0, room=25.0, warm=85.0, hot=90.0, critical=100.0)
STEP = 0.001
STALL, NO_LOAD = 7.785, 6.402
"""Printed joint-side figures of the V3's pitch joints: N m, rad/s."""
BACKLASH = math.radians(1.4)


@pytest.mark.parametrize("name", BODIES)
def test_any_request_ends_inside_the_tables(name: str) -> None:
    body = load_body(name)
    joints = tuple(joint_tree(body))
    limits = RequestLimits(body, joints)
    random = np.random.default_rng(0)
    for _ in range(200):
        wild = random.uniform(-3.0, 3.0, len(joints))
        tame = dict(zip(joints, limits.clip(wild).tolist(), strict=True))
        for joint, asked in zip(joints, wild.tolist(), strict=True):
            lower, upper = coupled_limits(body, joint, tame[COUPLED_TO.get(joint, joint)])
            assert tame[joint] == pytest.approx(min(max(asked, lower), upper), abs=1e-12)


def test_the_nominal_torque_leads_to_the_first_threshold() -> None:
    heat = MotorHeat(HEATING, np.array([1.61]))
    for _ in range(40):
        heat.update(np.array([1.61**2]), 100.0)
    assert heat.temperature[0] == pytest.approx(85.0, abs=1e-3)


@pytest.mark.parametrize("dt", [0.01, 1.0, 50.0])
def test_heating_and_cooling_are_exponential_whatever_the_step(dt: float) -> None:
    heat = MotorHeat(HEATING, np.array([2.0]))
    for _ in range(round(100.0 / dt)):
        heat.update(np.array([9.0]), dt)
    hot = 25.0 + 60.0 * (3.0 / 2.0) ** 2 * (1.0 - math.exp(-100.0 / 300.0))
    assert heat.temperature[0] == pytest.approx(hot, rel=1e-9)
    for _ in range(round(100.0 / dt)):
        heat.update(np.zeros(1), dt)
    assert heat.temperature[0] - 25.0 == pytest.approx((hot - 25.0) * math.exp(-100.0 / 300.0), rel=1e-9)


@pytest.mark.parametrize(
    ("temperature", "status", "factor"),
    [(25.0, 0, 1.0), (84.9, 0, 1.0), (87.5, 1, 0.85), (90.1, 2, 0.693), (95.0, 2, 0.35), (101.0, 3, 0.0)],
)
def test_status_and_stiffness_follow_the_temperature(temperature: float, status: int, factor: float) -> None:
    heat = MotorHeat(HEATING, np.ones(1))
    heat.temperature[:] = temperature
    assert heat.status() == [status]
    assert stiffness_factor(temperature, heat.levels) == pytest.approx(factor, abs=1e-9)


def test_standing_warms_the_loaded_legs_and_not_the_head() -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco", wear=load_wear("nominal")) as robot:
        for _ in range(200):
            frame = robot.advance(None)
    assert 25.001 < frame.temperature[INDEX["LKneePitch"]] < 30.0
    assert frame.temperature[INDEX["HeadYaw"]] == pytest.approx(25.0, abs=1e-3)
    assert frame.temperature[INDEX["LWristYaw"]] == 0.0


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


@pytest.mark.parametrize("speed", [0.05, -0.05])
def test_friction_of_the_load_is_a_share_of_the_torque_that_the_gear_passes_on(speed: float) -> None:
    passed, at_the_joint = (
        hold(knee(ServoParameters(load_friction=share)), 0.49, speed) for share in (0.0, 0.3)
    )
    assert at_the_joint == pytest.approx(passed - math.copysign(0.3 * abs(passed), speed), rel=1e-6)


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
