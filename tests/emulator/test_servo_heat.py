"""Motor temperatures and what they do to stiffness."""

import math

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.messages import ActuatorFrame
from emulator.robot import EmulatedRobot
from emulator.servo.heat import MotorHeat, stiffness_factor
from emulator.servo.parameters import Heating, ServoParameters
from emulator.wear import WearProfile, load_wear

HEATING = Heating(rise=60.0, time_constant=300.0, room=25.0, warm=85.0, hot=90.0, critical=100.0)


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


def test_thresholds_must_rise() -> None:
    with pytest.raises(ValueError, match="must rise in this order"):
        Heating(warm=90.0, hot=85.0)


def test_a_hot_knee_reports_what_is_left_of_its_stiffness_and_a_critical_one_falls_limp() -> None:
    wear = WearProfile(name="warm", servo=ServoParameters(heating=HEATING))
    start = POSTURES["StandInit"]
    with EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco", wear=wear, held=True, lift=0.5) as robot:
        servo = robot.servo
        knee = robot.engine.robot.joints.index("LKneePitch")
        command = ActuatorFrame(reply_to=0, position=start, stiffness=(0.8,) * 25)
        for temperature, stiffness in ((87.5, 0.68), (95.0, 0.28), (120.0, 0.0)):
            servo.heat.temperature[knee] = temperature
            frame = robot.advance(command)
            assert frame.temperature[INDEX["LKneePitch"]] == pytest.approx(temperature, abs=0.1)
            assert frame.stiffness[INDEX["LKneePitch"]] == pytest.approx(stiffness, abs=0.01)
            assert frame.stiffness[INDEX["RKneePitch"]] == pytest.approx(0.8, abs=1e-3)
        for _ in range(30):
            frame = robot.advance(command)
    assert frame.position[INDEX["LKneePitch"]] < start[INDEX["LKneePitch"]] - 0.1
    assert frame.position[INDEX["RKneePitch"]] == pytest.approx(start[INDEX["RKneePitch"]], abs=0.02)


def test_standing_warms_the_loaded_legs_and_not_the_head() -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco", wear=load_wear("nominal")) as robot:
        for _ in range(200):
            frame = robot.advance(None)
    assert 25.001 < frame.temperature[INDEX["LKneePitch"]] < 30.0
    assert frame.temperature[INDEX["HeadYaw"]] == pytest.approx(25.0, abs=1e-3)
    assert frame.temperature[INDEX["LWristYaw"]] == 0.0
