"""Each sensor error against its configured number: fixed seeds, many draws, five standard errors."""

import math

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from emulator.robot import EmulatedRobot
from emulator.sensors.fsr import ForceCells
from emulator.sensors.imu import TriaxialSensor, reported
from emulator.sensors.parameters import (
    EncoderParameters,
    FsrParameters,
    SensorParameters,
    SonarParameters,
    TriaxialParameters,
)
from emulator.sensors.suite import Encoders
from emulator.wear import WearProfile, load_wear

STEPS = 4096
STEP = 2.0 * math.pi / STEPS


def encoders(count: int = 22, **numbers: float) -> Encoders:
    return Encoders(STEPS, count, EncoderParameters(**numbers), np.random.default_rng(1))


def cells(seed: int = 1, largest: float = 25.0, **numbers: float) -> ForceCells:
    return ForceCells(largest, 0.01, FsrParameters(**numbers), np.random.default_rng(seed))


def triaxial(seed: int = 1, axes: int = 3, **numbers: float) -> TriaxialSensor:
    return TriaxialSensor(19.62, 0.00958, axes, TriaxialParameters(**numbers), np.random.default_rng(seed))


def within(samples: np.ndarray, sigma: float) -> None:
    """The samples are centred on 0 and have the standard deviation, to five standard errors."""
    assert abs(samples.mean()) < 5.0 * sigma / math.sqrt(samples.size)
    assert samples.std() == pytest.approx(sigma, rel=5.0 / math.sqrt(2.0 * samples.size))


def test_encoder_grid() -> None:
    angles = np.linspace(-2.0, 2.0, 22)
    read = encoders().read(angles)
    np.testing.assert_allclose(read / STEP, np.rint(read / STEP), atol=1e-9)
    assert np.abs(read - angles).max() <= STEP / 2.0
    np.testing.assert_array_equal(encoders(grid=False).read(angles), angles)


def test_encoder_residue_shifts_the_grid_by_the_same_amount_with_a_sign_of_the_joints_own() -> None:
    unit, residue = encoders(residue=4.2e-5), 4.2e-5
    signs = set()
    for angles in np.random.default_rng(2).uniform(-2.0, 2.0, (50, 22)):
        read = unit.read(angles)
        off = read - np.rint(read / STEP) * STEP
        np.testing.assert_allclose(np.abs(off), residue, atol=1e-12)
        assert np.abs(read - angles).max() <= STEP / 2.0 + 1e-12
        signs.add(tuple(np.sign(off)))
    assert len(signs) == 1
    assert set(signs.pop()) == {-1.0, 1.0}


def test_encoder_zero_error_is_constant_and_noise_is_not() -> None:
    zero = encoders(4000, grid=False, zero_error=0.005)
    off = zero.read(np.zeros(4000))
    within(off, 0.005)
    np.testing.assert_array_equal(zero.read(np.ones(4000)) - 1.0, (off + 1.0) - 1.0)
    noisy = encoders(10, grid=False, noise=0.0008)
    samples = np.array([noisy.read(np.zeros(10)) for _ in range(1000)])
    within(samples, 0.0008)


def test_fsr_gain_and_offset_are_constants_of_the_cells() -> None:
    many = [cells(seed, math.inf, gain=0.05, offset=0.1) for seed in range(300)]
    at_10 = np.array([one.read(np.full(8, 10.0)) for one in many])
    at_20 = np.array([one.read(np.full(8, 20.0)) for one in many])
    within((at_20 - at_10) / 10.0 - 1.0, 0.05)
    within(2.0 * at_10 - at_20, 0.1)
    np.testing.assert_array_equal([one.read(np.full(8, 10.0)) for one in many], at_10)
    assert len(set(at_10[0])) == 8


def test_fsr_drift_wanders_slowly_with_the_configured_spread() -> None:
    """Gauss-Markov: autocorrelation exp(-t / tau) and a constant standard deviation."""
    start = np.array([cells(seed, drift=0.4).drift for seed in range(300)])
    within(start, 0.4)
    unit = cells(drift=0.4, drift_time=0.5)
    path = np.array([unit.read(np.full(8, 10.0)) for _ in range(20000)]) - 10.0
    # 8 cells x 200 s hold about 1600 independent values (correlation time 2 x 0.5 s)
    assert path.std() == pytest.approx(0.4, rel=5.0 / math.sqrt(2.0 * 1600.0))
    later = np.mean(path[50:] * path[:-50]) / np.mean(path**2)
    assert later == pytest.approx(math.exp(-1.0), abs=0.1)
    assert np.abs(np.diff(path, axis=0)).max() < 5.5 * 0.4 * math.sqrt(1.0 - math.exp(-0.04))


def test_fsr_dead_band_range_and_step() -> None:
    forces = np.array([0.0, 0.3, 0.99, 1.0, 5.004, 5.006, 24.9, 40.0])
    assert cells().read(forces) == tuple(forces)
    assert cells(dead_band=1.0).read(forces) == (0.0, 0.0, 0.0, *forces[3:])
    assert cells(saturation=True).read(forces) == (*forces[:7], 25.0)
    read = cells(step=0.01).read(forces)
    np.testing.assert_allclose(read, [0.0, 0.3, 0.99, 1.0, 5.0, 5.01, 24.9, 40.0], atol=1e-9)


def test_triaxial_gain_and_bias_are_constants_of_the_axes() -> None:
    many = [triaxial(seed, gain=0.05, bias=0.1) for seed in range(600)]
    at_0 = np.array([one.measure((0.0, 0.0, 0.0)) for one in many])
    at_10 = np.array([one.measure((10.0, 10.0, 10.0)) for one in many])
    within(at_0, 0.1)
    within((at_10 - at_0) / 10.0 - 1.0, 0.05)
    np.testing.assert_array_equal([one.measure((0.0, 0.0, 0.0)) for one in many], at_0)


def test_triaxial_noise_range_and_step() -> None:
    noisy = triaxial(noise=0.0193)
    within(np.array([noisy.measure((1.0, 1.0, 1.0)) for _ in range(3000)]) - 1.0, 0.0193)
    assert triaxial(saturation=True).measure((30.0, -30.0, 3.0)) == (19.62, -19.62, 3.0)
    assert triaxial().measure((30.0, -30.0, 3.0)) == (30.0, -30.0, 3.0)
    read = np.array(reported((1.0, -2.0, 3.0), triaxial(quantisation=True).constants[-1])) / 0.00958
    np.testing.assert_allclose(read, np.rint([1.0 / 0.00958, -2.0 / 0.00958, 3.0 / 0.00958]), atol=1e-9)
    assert reported((1.0, -2.0, 3.0), triaxial().constants[-1]) == (1.0, -2.0, 3.0)


def test_one_effect_changes_no_draw_of_another() -> None:
    few, more = cells(noise=0.2), cells(noise=0.2, gain=0.05, offset=0.1, drift=0.4)
    quiet = np.array([few.read(np.full(8, 10.0)) for _ in range(300)])
    gains, offsets = np.array(more.gain), np.array(more.offset)
    for row in quiet:
        read = np.array(more.read(np.full(8, 10.0)))
        np.testing.assert_allclose(read - (10.0 * gains + offsets + more.drift), row - 10.0, atol=1e-12)
    np.testing.assert_array_equal(cells(gain=0.05).gain, more.gain)
    np.testing.assert_array_equal(triaxial(bias=0.1).bias, triaxial(bias=0.1, gain=0.1, noise=0.1).bias)
    np.testing.assert_array_equal(
        encoders(zero_error=0.1).zero_error, encoders(zero_error=0.1, residue=1e-5, noise=1.0).zero_error
    )


def test_sensors_do_not_share_draws() -> None:
    """Switching the force cells' errors on leaves every other sensor of the robot as it was."""
    base = SensorParameters(
        accelerometer=TriaxialParameters(bias=0.1, noise=0.1),
        gyroscope=TriaxialParameters(noise=0.01),
        encoders=EncoderParameters(noise=0.001),
        sonar=SonarParameters(noise=0.01),
    )
    with_cells = msgspec.structs.replace(base, fsr=FsrParameters(gain=0.1, noise=0.1, drift=0.1))
    frames = []
    for parameters in (base, with_cells):
        wear = WearProfile(name="test", sensors=parameters)
        with EmulatedRobot(load_body("nao-v3"), seed=4, engine="mujoco", wear=wear, settle=0.05) as robot:
            frames.append([robot.advance(None) for _ in range(10)])
    for one, other in zip(*frames, strict=True):
        assert one.fsr != other.fsr
        assert msgspec.structs.replace(one, fsr=other.fsr) == other


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
def test_the_inertial_unit_never_repeats_a_sample(name: str) -> None:
    body = load_body(name)
    wear = WearProfile(name="test", sensors=load_wear("nominal").sensors)
    with EmulatedRobot(body, seed=0, engine="mujoco", wear=wear, held=True, lift=0.3, settle=0.0) as robot:
        frames = [robot.advance(None) for _ in range(200)]
    different = len({(f.accelerometer, f.gyroscope, f.angle) for f in frames})
    # a V3 reports coarse steps
    assert different == len(frames) or (name.startswith("nao-v3") and different > len(frames) // 5)
    for frame in frames:
        counts = np.array(frame.accelerometer) / body.inertial_unit.accelerometer_step
        np.testing.assert_allclose(counts, np.rint(counts), atol=1e-6)
        counts = np.array(frame.gyroscope) / body.inertial_unit.gyroscope_step
        np.testing.assert_allclose(counts, np.rint(counts), atol=1e-6)


@pytest.mark.parametrize("profile", ["nominal", "worn"])
def test_profiles_set_every_number_that_is_not_zero_on_purpose(profile: str) -> None:
    sensors = load_wear(profile).sensors
    assert load_wear("ideal").sensors == SensorParameters()
    for group in (sensors.fsr, sensors.accelerometer, sensors.gyroscope, sensors.sonar):
        assert all(getattr(group, field) for field in group.__struct_fields__)
    assert sensors.battery.capacity > 0.0
