"""Drives: torque, speed, stiffness, gear of the hips, stops."""

import math

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.messages import ActuatorFrame
from emulator.drives import take_over
from emulator.robot import EmulatedRobot
from emulator.servo.parameters import Backlash, ServoParameters
from emulator.servo.servo import Servo
from tests.servos import torques

START = POSTURES["StandInit"]
STEP = 0.001


def drive(
    *joints: str, parameters: ServoParameters | None = None, stiffness: float = 1.0, at: float = 0.0
) -> Servo:
    """Drives of the V3 on their own, resting at an angle, asked to turn as far up as they can."""
    servo = Servo(load_body("nao-v3"), joints, parameters or ServoParameters(), np.full(len(joints), at), STEP)
    servo.latch((9.0,) * 25, (stiffness,) * 25)
    return servo


def led(servo: Servo, speed: float, start: float = 0.0, steps: int = 20) -> np.ndarray:
    """Torques of drives whose joints are led from an angle at a constant speed for a cycle, N m."""
    size = len(servo.stall)
    for k in range(steps):
        torque = torques(servo, np.full(size, start + k * speed * STEP), np.full(size, speed))
    servo.end_cycle()
    return torque


def command(position: tuple[float, ...] = START, stiffness: float = 1.0, reply_to: int = 0) -> ActuatorFrame:
    return ActuatorFrame(reply_to=reply_to, position=position, stiffness=(stiffness,) * 25)


def moved(joint: str, angle: float) -> tuple[float, ...]:
    position = list(START)
    position[INDEX[joint]] += angle
    return tuple(position)


def test_a_request_acts_after_the_delay_and_the_later_of_two_at_one_instant_counts() -> None:
    servo = drive("HeadYaw", parameters=ServoParameters(delay=0.013))
    servo.latch((-9.0,) * 25, (1.0,) * 25)
    for change in (-1, 3, -1):
        servo.advance(10)
        assert servo.drives.change == change
    take_over(servo.drives.records)
    assert servo.drives.records["request"][0] == pytest.approx(-2.0857)  # the joint's lower end


# printed joint-side figures of the V3 motors: no-load rad/s, stall N m
PRINTED = {
    "LHipRoll": (4.1617, 11.97),
    "LAnkleRoll": (4.1617, 11.97),
    "LHipPitch": (6.4024, 7.78),
    "RKneePitch": (6.4024, 7.78),
    "HeadYaw": (8.2680, 2.27),
    "LElbowRoll": (7.1941, 2.61),
}


@pytest.mark.parametrize("backlash", [0.0, 0.02])
@pytest.mark.parametrize(("joint", "speed", "stall"), [(j, *v) for j, v in PRINTED.items()])
def test_torque_speed_line(joint: str, speed: float, stall: float, backlash: float) -> None:
    every = msgspec.convert(dict.fromkeys(Backlash.__struct_fields__, backlash), Backlash)
    parameters = ServoParameters(backlash=every)
    still, half, full = (
        float(led(drive(joint, parameters=parameters, at=-1.0), share * speed, -1.0)[0])
        for share in (0.0, 0.5, 1.0)
    )
    assert still == pytest.approx(stall, rel=4e-3)
    assert half == pytest.approx(stall / 2.0, rel=4e-3)
    assert full == pytest.approx(0.0, abs=4e-3 * stall)


@pytest.mark.parametrize(("stiffness", "share"), [(1.0, 1.0), (0.5, 0.5), (0.0, 0.0), (-1.0, 0.0), (3.0, 1.0)])
def test_stiffness_is_a_share_of_the_current_limit(stiffness: float, share: float) -> None:
    servo = drive("LKneePitch", stiffness=stiffness)
    assert float(led(servo, 0.0)[0]) == pytest.approx(share * 7.78, rel=2e-3)
    # stalled with full current: stall torque over torque constant, here 21.6 V / 837.8 rad/s
    assert float(servo.current()[0]) == pytest.approx(share * 59.5e-3 * 837.8 / 21.6, rel=1e-3)
    # the share of the voltage that this takes, times the current
    assert servo.drawn() == pytest.approx(share**2 * 59.5e-3 * 837.8 / 21.6, rel=2e-3)


def test_a_drive_that_lifts_pays_for_heat_and_work() -> None:
    """On its torque-speed line at full voltage a motor draws its own current, whatever it turns into work."""
    servo = drive("LKneePitch")
    speed = 0.5 * PRINTED["RKneePitch"][0]
    led(servo, speed)
    led(servo, speed, 20 * speed * STEP)
    assert float(servo.current()[0]) == pytest.approx(0.5 * 59.5e-3 * 837.8 / 21.6, rel=0.01)
    assert servo.drawn() == pytest.approx(float(servo.current()[0]), rel=0.01)


@pytest.mark.parametrize("joint", ["LHipPitch", "LAnkleRoll", "HeadYaw"])
def test_no_joint_is_faster_than_its_motor(joint: str, physics: str) -> None:
    body = load_body("nao-v3")
    speed = {"LHipPitch": 6.402, "LKneePitch": 6.402, "HeadYaw": 8.268}.get(joint, 4.162)
    with EmulatedRobot(body, engine=physics, seed=0, held=True, lift=0.3, settle=0.2) as robot:
        target = command(moved(joint, math.radians(60.0)))
        track = [robot.advance(target).position[INDEX[joint]] for _ in range(40)]
    fastest = np.abs(np.diff(track)).max() / body.cycle
    # gravity may drive a joint a little beyond the motor; one encoder count is 0.15 rad/s over a cycle
    assert 0.9 * speed < fastest < 1.05 * speed + 0.16


@pytest.mark.parametrize("joint", ["LKneePitch", "LAnkleRoll", "LHipYawPitch"])
def test_step_of_a_free_leg_settles(joint: str, physics: str) -> None:
    step = math.radians(-10.0 if joint == "LHipYawPitch" else 10.0)
    with EmulatedRobot(load_body("nao-v3"), engine=physics, seed=0, held=True, lift=0.3, settle=0.2) as robot:
        track = [robot.advance(command(moved(joint, step))).position[INDEX[joint]] for _ in range(60)]
    reached = (np.array(track) - START[INDEX[joint]]) / step
    assert reached.max() < 1.25
    np.testing.assert_allclose(reached[40:], 1.0, atol=0.03)


def test_hips_turn_together(physics: str) -> None:
    with EmulatedRobot(load_body("nao-v3"), engine=physics, seed=0) as robot:
        joints = robot.multibody.joints
        left, right = joints.index("LHipYawPitch"), joints.index("RHipYawPitch")
        apart = 0.0
        for k in range(100):
            # the left leg is pulled up, so that the loads of the hips differ
            position = list(moved("LHipYawPitch", -0.1 * k / 100.0))
            position[INDEX["LHipRoll"]] += 0.1 * k / 100.0
            robot.advance(command(tuple(position)))
            apart = max(apart, abs(robot.multibody.position[left] - robot.multibody.position[right]))
        assert apart < 1e-4
        assert robot.multibody.position[left] < -0.05


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
def test_standing_sags_less_than_a_fifth_of_a_degree(name: str, physics: str) -> None:
    with EmulatedRobot(load_body(name), engine=physics, seed=0) as robot:
        robot.advance(None)
        joints = robot.truth().joints
        present = [i for i in range(25) if robot.frame.stiffness[i] > 0.0]
        sag = max(abs(joints[i] - START[i]) for i in present)
        assert math.degrees(sag) < 0.2
        assert np.abs(robot.multibody.velocity).max() < 0.05


def test_without_stiffness_it_collapses(physics: str) -> None:
    with EmulatedRobot(load_body("nao-v3"), engine=physics, seed=0) as robot:
        assert not robot.truth().fell
        height = robot.truth().torso_position[2]
        for _ in range(200):
            robot.advance(command(stiffness=0.0))
        assert robot.truth().fell
        assert robot.truth().torso_position[2] < 0.6 * height
        assert max(robot.frame.current) == 0.0


def test_stops_hold_a_limp_robot_hung_upside_down(physics: str) -> None:
    body = load_body("nao-v3.3")
    with EmulatedRobot(
        body,
        engine=physics,
        seed=0,
        held=True,
        lift=1.0,
        settle=0.0,
        orientation=(0.9238795325, 0.0, 0.3826834324, 0.0),
    ) as robot:
        beyond = 0.0
        for _ in range(200):
            robot.advance(command(stiffness=0.0))
            for name, angle in zip(robot.multibody.joints, robot.multibody.position, strict=True):
                beyond = max(beyond, angle - body.joints[name].upper, body.joints[name].lower - angle)
        at_stop = [
            name
            for name, angle in zip(robot.multibody.joints, robot.multibody.position, strict=True)
            if min(body.joints[name].upper - angle, angle - body.joints[name].lower) < 0.02
        ]
    assert math.degrees(beyond) < 1.0
    assert at_stop


def test_requests_are_clipped_to_the_limits(physics: str) -> None:
    body = load_body("nao-v3")
    with EmulatedRobot(body, engine=physics, seed=0, held=True, lift=0.3, settle=0.0) as robot:
        for _ in range(100):
            robot.advance(command(moved("LKneePitch", 5.0)))
        knee = robot.truth().joints[INDEX["LKneePitch"]]
    assert knee == pytest.approx(body.joints["LKneePitch"].upper, abs=0.01)
