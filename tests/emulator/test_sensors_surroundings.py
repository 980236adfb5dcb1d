"""Buttons, bumpers, battery and sonar."""

import math
from itertools import pairwise

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import JOINTS
from bridge.body.quantities import joint_no_load_speed, joint_stall_torque
from emulator.engine.pybullet.client import bullet
from emulator.robot import EmulatedRobot
from emulator.sensors.parameters import BatteryParameters, SensorParameters, SonarParameters
from emulator.sensors.suite import TOUCH, Battery
from emulator.wear import WearProfile

FRONT = 0.0507  # x of the sonars in the torso, m


def block(robot: EmulatedRobot, centre: tuple[float, ...], half: tuple[float, ...]) -> int:
    client = robot.engine.client
    shape = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    return int(bullet.createMultiBody(0.0, shape, basePosition=centre, physicsClientId=client))


def remove(robot: EmulatedRobot, body: int) -> None:
    bullet.removeBody(body, physicsClientId=robot.engine.client)


def test_pressing_buttons() -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=0, settle=0.1) as robot:
        assert robot.frame.touch == (0.0,) * 14
        for slot, name in enumerate(TOUCH):
            robot.sensors.touch.press(name)
            assert robot.advance(None).touch == tuple(float(i == slot) for i in range(14))
            robot.sensors.touch.press(name, 0.0)
        robot.sensors.touch.press("chest")
        robot.reset()
        assert robot.advance(None).touch == (0.0,) * 14


@pytest.mark.parametrize("side", ["L", "R"])
@pytest.mark.parametrize(("offset", "bumper"), [(0.015, "left"), (-0.015, "right")])
def test_a_toe_against_a_block_presses_its_bumper(side: str, offset: float, bumper: str) -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=0, settle=0.2) as robot:
        model = robot.multibody.model
        foot = bullet.getLinkState(model.robot, model.feet[side], physicsClientId=model.client)[4]
        front = max(x for x, _ in robot.body.foot.sole)
        body = block(robot, (foot[0] + front + 0.043, foot[1] + offset, 0.02), (0.05, 0.01, 0.02))
        pressed = {name for name, on in zip(TOUCH, robot.advance(None).touch, strict=True) if on}
        assert pressed == {f"{'left' if side == 'L' else 'right'}_bumper_{bumper}"}
        remove(robot, body)
        for _ in range(5):
            robot.advance(None)
        assert robot.frame.touch == (0.0,) * 14


def test_battery_counts_charge() -> None:
    """27.6 W h at 21.6 V and 2 A last 0.639 h; a battery of half the capacity lasts half of that."""
    for capacity in (1.0, 0.5):
        battery = Battery(BatteryParameters(capacity=capacity, idle_current=1.5), 27.6, 0.01)
        for _ in range(36000):
            battery.update(0.5)
        charge, current, status, _ = battery.read()
        assert charge == pytest.approx(1.0 - 0.1 * 2.0 * 21.6 / (27.6 * capacity), rel=1e-9)
        assert current == -2.0
        assert int(status) & 0x20 and not int(status) & 0x80  # discharging, not charging


def test_battery_ends_empty_an_ideal_one_never_and_one_on_the_charger_neither() -> None:
    small = Battery(BatteryParameters(capacity=1.0, idle_current=10.0), 1e-3, 0.01)
    charging = Battery(BatteryParameters(capacity=1.0, idle_current=10.0), 1e-3, 0.01, charger=True)
    ideal = Battery(BatteryParameters(), 27.6, 0.01)
    for battery in (small, charging, ideal):
        for _ in range(100):
            battery.update(1.0)
    assert small.read()[0] == 0.0
    charge, _, status, _ = charging.read()
    assert charge == 1.0
    captured = 0x80D8 - 0x10000  # of a robot on its charger, at 0.99
    assert all(int(status) & bit == captured & bit for bit in (0x8000, 0x80, 0x40, 0x20, 0x08))
    assert -0x8000 <= status < 0x8000
    assert (*ideal.read()[:2], ideal.read()[3]) == (1.0, -1.0, 25.0)


def test_battery_of_a_standing_robot_runs_down() -> None:
    """What is drawn to stand still is the copper loss, sum of R i^2 with R = U / stall current, and no more."""
    sensors = SensorParameters(battery=BatteryParameters(capacity=1.0, idle_current=1.0))
    body = load_body("nao-v3")
    with EmulatedRobot(body, seed=0, wear=WearProfile(name="test", sensors=sensors)) as robot:
        for _ in range(100):
            robot.advance(None)
        stall = {
            name: joint_stall_torque(body, name) * joint_no_load_speed(body, name) / 21.6
            for name in body.joints
        }
        before = robot.frame.battery[0]
        drawn = 0.0
        for _ in range(20):
            frame = robot.advance(None)
            heat = sum(i * i / stall[name] for name, i in zip(JOINTS, frame.current, strict=True) if i)
            assert -frame.battery[1] - 1.0 == pytest.approx(heat, rel=0.02)
            drawn -= frame.battery[1] * 0.01
        assert before - frame.battery[0] == pytest.approx(drawn * 21.6 / (27.6 * 3600.0), rel=1e-6)


def sonar_after(robot: EmulatedRobot, seconds: float = 0.2) -> tuple[float, float]:
    for _ in range(round(seconds / robot.body.cycle)):
        robot.advance(None)
    return robot.frame.sonar


@pytest.mark.parametrize("distance", [0.4, 2.0])
def test_sonar_measures_a_wall_across_each_axis(distance: float) -> None:
    """A wall square to the left axis stands at its distance from the sensor; the right one looks elsewhere."""
    with EmulatedRobot(load_body("nao-v3"), seed=0, settle=0.0, lift=0.5, held=True) as robot:
        torso = robot.truth()
        turn = np.array(bullet.getMatrixFromQuaternion(torso.torso_orientation)).reshape(3, 3)
        yaw, down = 0.39265, 0.04365
        axis = turn @ (math.cos(yaw) * math.cos(down), math.sin(yaw) * math.cos(down), -math.sin(down))
        sensor = np.array(torso.torso_position) + turn @ (0.0507, 0.03785, 0.06035)
        client = robot.engine.client
        shape = bullet.createCollisionShape(
            bullet.GEOM_BOX, halfExtents=(0.01, 0.1, 0.1), physicsClientId=client
        )
        facing = bullet.getQuaternionFromEuler((0.0, math.asin(-axis[2]), math.atan2(axis[1], axis[0])))
        centre = sensor + (distance + 0.01) * axis
        bullet.createMultiBody(
            0.0, shape, basePosition=centre.tolist(), baseOrientation=facing, physicsClientId=client
        )
        left, right = sonar_after(robot)
        assert left == pytest.approx(distance, abs=0.002)
        assert right == 2.55


def test_sonar_ends_of_range_and_pace() -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=0, settle=0.0, lift=0.3, held=True) as robot:
        x = robot.truth().torso_position[0] + FRONT
        wall = block(robot, (x + 0.15 + 0.05, 0.0, 0.6), (0.05, 1.0, 0.4))
        assert sonar_after(robot) == (0.25, 0.25)
        remove(robot, wall)
        wall = block(robot, (x + 4.0, 0.0, 0.6), (0.05, 3.0, 0.4))
        assert sonar_after(robot) == (2.55, 2.55)
        remove(robot, wall)
        robot.advance(None)
        block(robot, (x + 1.0 + 0.05, 0.0, 0.6), (0.05, 2.0, 0.4))
        readings = [robot.advance(None).sonar for _ in range(25)]
        assert [i for i, (a, b) in enumerate(pairwise(readings)) if a != b] == [8]
        assert 0.9 < readings[-1][0] < 1.2


def test_sonar_noise_and_step() -> None:
    sensors = SensorParameters(sonar=SonarParameters(noise=0.03, step=0.01))
    with EmulatedRobot(
        load_body("nao-v3"),
        seed=0,
        wear=WearProfile(name="test", sensors=sensors),
        settle=0.0,
        lift=0.3,
        held=True,
    ) as robot:
        x = robot.truth().torso_position[0]
        block(robot, (x + 1.05, 0.0, 0.6), (0.05, 2.0, 0.4))
        state = robot.multibody.state()
        readings = []
        for _ in range(4000):
            robot.sensors.sonars.update(state)
            readings.append(robot.sensors.sonars.read())
        samples = np.array(readings[::10])
        assert samples.std() == pytest.approx(0.03, rel=5.0 / math.sqrt(2.0 * samples.size))
        np.testing.assert_allclose(samples / 0.01, np.rint(samples / 0.01), atol=1e-6)
