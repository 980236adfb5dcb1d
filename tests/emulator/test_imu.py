"""The fused angle from the two sensors alone."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bridge.body import load_body
from bridge.body.postures import POSTURES
from bridge.messages import ActuatorFrame
from bridge.types import Vec3
from emulator.engine.pybullet.client import bullet
from emulator.robot import EmulatedRobot
from emulator.sensors.fusion import FusedAngle, fuse
from emulator.sensors.imu import mean_rate
from emulator.sensors.parameters import FusedAngleParameters, SensorParameters
from emulator.wear import WearProfile

G = 9.81
SWITCHING = FusedAngleParameters(motion_time=0.51, rest_time=0.038, rest_rate=0.02)
FILTER = FusedAngleParameters()
TILTS = [(0.0, 0.0), (30.0, 0.0), (-30.0, 0.0), (0.0, 30.0), (0.0, -30.0), (20.0, -22.0), (-12.0, 27.0)]


def gravity(roll: float, pitch: float) -> tuple[float, float, float]:
    """Specific force at rest in a torso with R = Ry(pitch) Rx(roll)."""
    turn = Rotation.from_euler("ZYX", [0.7, pitch, roll])
    x, y, z = turn.inv().apply([0.0, 0.0, G])
    return float(x), float(y), float(z)


def update(fused: FusedAngle, acceleration: Vec3, rate: Vec3, dt: float) -> None:
    fuse(fused.state, acceleration, rate, dt, *fused.constants)


@pytest.mark.parametrize("tilt", TILTS)
def test_at_rest_the_accelerometer_decides(tilt: tuple[float, float]) -> None:
    roll, pitch = np.radians(tilt)
    fused = FusedAngle(G, (0.0, 0.0, G), SWITCHING)
    for _ in range(1000):
        update(fused, gravity(roll, pitch), (0.0, 0.0, 0.0), 0.01)
    np.testing.assert_allclose(np.degrees(fused.angle), tilt, atol=0.3)


def test_in_motion_the_gyroscope_decides() -> None:
    """Swing of 20 deg at 1 Hz in roll under an accelerometer shaken by half of gravity to and fro."""
    fused, worst, before = FusedAngle(G, (0.0, 0.0, G), FILTER), 0.0, 0.0
    for k in range(1, 301):
        t = 0.01 * k
        roll = math.radians(20.0) * math.sin(2.0 * math.pi * t)
        shake = 5.0 * math.sin(2.0 * math.pi * 1.7 * t)
        x, y, z = gravity(roll, 0.0)
        update(fused, (x + shake, y - shake, z), ((roll - before) / 0.01, 0.0, 0.0), 0.01)
        before = roll
        worst = max(worst, abs(fused.angle[0] - roll), abs(fused.angle[1]))
    assert math.degrees(worst) < 1.0


@pytest.mark.parametrize("time_constant", [0.2, 2.0])
@pytest.mark.parametrize("frequency", [3.0, 12.0])
def test_a_swing_about_the_ankle_is_read_as_the_complementary_filter_says(
    time_constant: float, frequency: float
) -> None:
    """An accelerometer h over the pivot reads theta - (h/g) theta''; fused, 1 - (h/g) s^2 / (1 + T s)."""
    h, amplitude, dt = 0.33, 0.05, 0.001
    fused = FusedAngle(G, (0.0, 0.0, G), FusedAngleParameters(motion_time=time_constant))
    read, basis = [], []
    for k in range(1, round((8.0 * time_constant + 8.0 * math.pi / frequency) / dt)):
        phase = frequency * k * dt
        theta, rate = amplitude * math.sin(phase), amplitude * frequency * math.cos(phase)
        update(fused, (-h * frequency * frequency * theta - G * theta, 0.0, G), (0.0, rate, 0.0), dt)
        read.append(fused.angle[1])
        basis.append((math.sin(phase), math.cos(phase)))
    last = round(2.0 * math.pi / frequency / dt)
    in_phase, ahead = (
        np.linalg.lstsq(np.array(basis[-last:]), np.array(read[-last:]), rcond=None)[0] / amplitude
    )
    expected = 1.0 + h / G * frequency**2 / (1.0 + 1j * frequency * time_constant)
    assert complex(in_phase, ahead) == pytest.approx(expected, abs=0.02)


def test_a_steady_turn_follows_the_accelerometer_and_a_changing_one_the_gyroscope() -> None:
    """At a constant rate the accelerometer leads with 0.038 s, so the angle jumps to its direction, here
    level."""
    fused = FusedAngle(G, (0.0, 0.0, G), SWITCHING)
    for k in range(1, 51):  # speeds up by 3 rad/s^2: within 0.09 s the rate varies by 0.08 rad/s
        update(fused, (0.0, 0.0, G), (0.0, 0.03 * k, 0.0), 0.01)
    led = fused.angle[1]
    # closed form of x' = 3 t - x / T at 0.5 s, T = 0.51 s
    t, T = 0.5, 0.51
    assert led == pytest.approx(3.0 * T * (t - T * (1.0 - math.exp(-t / T))), rel=0.05)
    for _ in range(40):
        update(fused, (0.0, 0.0, G), (0.0, 0.5, 0.0), 0.01)
    # a steady rate r leaves r T of the short time constant
    assert fused.angle[1] == pytest.approx(0.5 * 0.038, rel=0.3)


@given(st.lists(st.floats(-8.0, 8.0), min_size=3, max_size=3), st.integers(0, 2**32 - 1))
def test_mean_rate_of_a_steady_turn_is_its_rate(rate: list[float], seed: int) -> None:
    before = Rotation.random(random_state=seed)
    after = before * Rotation.from_rotvec(0.01 * np.array(rate))
    rows = [tuple(turn.as_matrix().ravel().tolist()) for turn in (before, after)]
    np.testing.assert_allclose(mean_rate(*rows, 0.01), rate, atol=1e-9)


def test_rezeroed_unit_begins_level_and_finds_its_tilt_again() -> None:
    x, y, z, w = Rotation.from_euler("ZYX", [0.0, 12.0, -8.0], degrees=True).as_quat().tolist()
    with EmulatedRobot(
        load_body("nao-v3"),
        seed=0,
        held=True,
        lift=0.3,
        settle=0.0,
        orientation=(x, y, z, w),
        wear=WearProfile(name="test", sensors=SensorParameters(fused_angle=SWITCHING)),
    ) as robot:
        robot.sensors.inertial.rezero()
        # level but for one cycle of the short time constant: a quarter of the tilt
        assert abs(math.degrees(robot.advance(None).angle[1])) < 0.3 * 12.0
        for _ in range(150):
            robot.advance(None)
        np.testing.assert_allclose(np.degrees(robot.frame.angle), (-8.0, 12.0), atol=0.3)


@pytest.mark.parametrize("tilt", TILTS)
def test_robot_held_at_a_tilt(tilt: tuple[float, float]) -> None:
    x, y, z, w = Rotation.from_euler("ZYX", [40.0, tilt[1], tilt[0]], degrees=True).as_quat().tolist()
    with EmulatedRobot(
        load_body("nao-v3"), seed=0, held=True, lift=0.3, settle=0.2, orientation=(x, y, z, w)
    ) as robot:
        np.testing.assert_allclose(np.degrees(robot.frame.angle), tilt, atol=0.3)
        np.testing.assert_allclose(robot.frame.accelerometer, gravity(*np.radians(tilt)), atol=1e-3)


def test_free_fall_weighs_nothing_and_follows_the_parabola() -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=0, settle=0.0, lift=1.0) as robot:
        before = robot.truth().com
        np.testing.assert_allclose(robot.advance(None).accelerometer, (0.0, 0.0, 0.0), atol=1e-6)
        kick = ActuatorFrame(reply_to=0, position=POSTURES["Stand"], stiffness=(1.0,) * 25)
        for _ in range(19):
            robot.advance(kick)
        after = robot.truth()
        # whatever the joints do; steps of dt add g dt each before they move: g dt^2 n (n + 1) / 2
        n, dt = 200, 0.001
        fallen = np.array(before) - np.array(after.com)
        np.testing.assert_allclose(fallen, (0.0, 0.0, G * dt * dt * n * (n + 1) / 2.0), atol=2e-4)
        assert sum(robot.frame.fsr) == 0.0
        assert after.zmp is None


@pytest.mark.parametrize(("name", "seen"), [("nao-v3", 0.0), ("nao-v6", 0.7)])
def test_gyroscope_is_right_handed_and_has_the_axes_of_its_body(name: str, seen: float) -> None:
    with EmulatedRobot(load_body(name), seed=0, settle=0.0, lift=2.0) as robot:
        model = robot.multibody.model
        for axis in range(3):
            robot.reset()
            omega = [0.0, 0.0, 0.0]
            omega[axis] = 0.7
            rotation = np.array(bullet.getMatrixFromQuaternion(robot.truth().torso_orientation)).reshape(3, 3)
            bullet.resetBaseVelocity(
                model.robot, (0.0, 0.0, 0.0), (rotation @ omega).tolist(), physicsClientId=model.client
            )
            rate = robot.advance(None).gyroscope
            assert rate[axis] == pytest.approx(seen if axis == 2 else 0.7, abs=0.05)
