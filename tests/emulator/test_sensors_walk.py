"""Nominal sensors in a walking robot, against the ground truth.

Drives are ideal and the walk is open loop, so that the robot does walk whatever the sensors say.
"""

from dataclasses import dataclass
from functools import cache

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import load_body
from emulator.robot import EmulatedRobot
from emulator.sensors.fsr import FootForceSensors
from emulator.wear import WearProfile, load_wear
from walker.controller import Controller, WalkOrder
from walker.gaits import gait_parameters, make_gait
from walker.parameters import controller_parameters
from walker.switches import Switches

SENSORS = WearProfile(name="test", sensors=load_wear("nominal").sensors)


@dataclass(frozen=True)
class Walk:
    """What was measured and what was true, one row per cycle; forces of the left foot first."""

    angle: np.ndarray
    true_angle: np.ndarray
    cells: np.ndarray
    force: np.ndarray
    cop: np.ndarray
    gain: np.ndarray
    offset: np.ndarray


@cache
def walk(name: str, gait: str, steps: int) -> Walk:
    body = load_body(name)
    rows: list[tuple[float, ...]] = []
    with EmulatedRobot(body, seed=0, engine="mujoco", wear=SENSORS) as robot:
        open_loop = msgspec.structs.replace(controller_parameters(gait), switches=Switches())
        controller = Controller(
            body, make_gait(gait, gait_parameters(gait), body), WalkOrder(steps=steps), body.cycle, open_loop
        )
        cells = robot.sensors.cells
        drift = []
        for _ in range(6000):
            frame, truth = robot.frame, robot.truth()
            _, pitch, roll = Rotation.from_quat(truth.torso_orientation).as_euler("ZYX")
            loads = []
            for contact in robot.multibody.contacts.feet.values():
                loads += [contact.normal_force, *(contact.cop or (np.nan, np.nan))]
            rows.append((*frame.angle, roll, pitch, *frame.fsr, *loads))
            drift.append(cells.drift)
            command = controller.tick(frame)
            if controller.done or truth.fell:
                break
            robot.advance(command)
        assert not truth.fell
        assert controller.done
        gain, offset = np.array(cells.gain), np.array(cells.offset) + np.array(drift)
    table = np.array(rows)
    return Walk(
        angle=table[:, 0:2],
        true_angle=table[:, 2:4],
        cells=table[:, 4:12].reshape(-1, 2, 4),
        force=table[:, [12, 15]],
        cop=np.stack([table[:, 13:15], table[:, 16:18]], axis=1),
        gain=gain.reshape(2, 4),
        offset=offset.reshape(-1, 2, 4),
    )


@pytest.mark.parametrize(
    ("name", "gait", "steps"), [("nao-v3", "static", 2), ("nao-v3", "dynamic", 10), ("nao-v6", "dynamic", 10)]
)
def test_fused_angle_in_walking(name: str, gait: str, steps: int) -> None:
    run = walk(name, gait, steps)
    error = np.degrees(run.angle - run.true_angle)
    # the accelerations of a step pass the filter: the price of the zero of (4.12)
    assert np.sqrt((error**2).mean(axis=0)).max() < 2.0
    # the gait does move the torso more than the error may be
    assert np.degrees(np.ptp(run.true_angle, axis=0)).max() > 3.0


def test_force_cells_in_a_dynamic_walk() -> None:
    """Less the configured gains and offsets, with no cell at its end: the forces but for the noise.

    Five standard deviations: 0.22 N a cell is 0.44 N of the sum, and 3 mm of the centre under 10 N.
    """
    run = walk("nao-v3", "dynamic", 10)
    body = load_body("nao-v3")
    range_, dead = body.fsr.range, SENSORS.sensors.fsr.dead_band
    checked = 0
    for foot, places in enumerate((body.fsr.L, body.fsr.R)):
        sensors, xy = FootForceSensors(places), np.array(places)[:, :2]
        for k, force in enumerate(run.force[:, foot]):
            cells = run.cells[k, foot]
            if force < 10.0 or cells.max() >= range_:
                continue
            x, y = run.cop[k, foot]
            true_cells = np.array(sensors.distribute(force, (x, y)))
            inside = np.hypot(*(true_cells @ xy / force - (x, y))) < 1e-6
            if not inside or true_cells.min() < dead:
                continue
            corrected = (cells - run.offset[k, foot]) / run.gain[foot]
            assert corrected.sum() == pytest.approx(force, rel=0.02, abs=5.0 * 0.44)
            assert np.hypot(*(corrected @ xy / corrected.sum() - (x, y))) < 0.015
            # uncorrected: five standard errors of a gain of 5 % a cell, and of one of 10 % for all
            assert cells.sum() == pytest.approx(force, rel=0.02 + 5.0 * 0.15, abs=3.0)
            checked += 1
    assert checked > 200


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
@pytest.mark.parametrize("tilt", [(30.0, 0.0), (-20.0, 22.0)])
@pytest.mark.parametrize("seed", [0, 1])
def test_angle_at_rest_with_nominal_sensors(name: str, tilt: tuple[float, float], seed: int) -> None:
    x, y, z, w = Rotation.from_euler("ZYX", [40.0, tilt[1], tilt[0]], degrees=True).as_quat().tolist()
    with EmulatedRobot(
        load_body(name),
        seed=seed,
        engine="mujoco",
        wear=SENSORS,
        held=True,
        lift=0.3,
        settle=0.0,
        orientation=(x, y, z, w),
    ) as robot:
        angles = np.degrees([robot.advance(None).angle for _ in range(50)])
    # three standard deviations of a bias of 0.05 m/s^2 on each of two axes, and the noise
    np.testing.assert_allclose(angles, np.tile(tilt, (50, 1)), atol=1.3)
