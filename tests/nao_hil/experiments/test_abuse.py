"""Half a minute of abuse, and the energy meter it relies on."""

import numpy as np
import pytest

from bridge.body import load_body
from bridge.messages.faults import PowerLoss
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from nao_hil.experiments.abuse import run

BODY = load_body("nao-v3")
MASS = sum(link.mass for link in BODY.links.values())
G = 9.81


def test_the_energy_of_a_robot_at_rest_is_its_weight_times_the_height_of_its_centre_of_mass() -> None:
    with EmulatedRobot(BODY, seed=0) as robot:
        for _ in range(100):
            robot.advance(None)
        assert robot.engine.robot.energy() == pytest.approx(MASS * G * robot.truth().com[2], rel=1e-4)


def test_a_limp_robot_in_free_fall_keeps_its_energy() -> None:
    with EmulatedRobot(BODY, seed=0, settle=0.0, lift=2.0) as robot:
        robot.faults.start(PowerLoss(), 0.0, 0.0)
        robot.advance(None)
        start, height = robot.engine.robot.energy(), robot.truth().com[2]
        for _ in range(40):
            robot.advance(None)
        assert height - robot.truth().com[2] > 0.7
        # steps of 1 ms leave m g^2 t dt / 2 = 0.1 J of the 30 J that turn from height into speed
        assert robot.engine.robot.energy() == pytest.approx(start, abs=0.01 * MASS * G * 0.7)


@pytest.mark.parametrize(("seed", "wear"), [(11, "nominal"), (12, "ideal")])
def test_the_robot_stays_a_physical_body_under_abuse(seed: int, wear: str) -> None:
    result = run(10.0, seed=seed, body=BODY, wear=load_wear(wear))
    assert result["finite"]
    assert result["stop_excess_deg"] <= 1.0
    assert result["energy_rise_j"] <= 0.05
    assert result["falls"] > 0
    assert np.isfinite(result["farthest_m"]) and result["farthest_m"] < 10.0
