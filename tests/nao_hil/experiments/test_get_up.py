"""Drops of the experiment `get-up`."""

from __future__ import annotations

import numpy as np
import pytest

from emulator.start import random_drop
from nao_hil.experiments.get_up import DROP, WARM, dropped, get_up
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig


def test_no_limb_of_a_dropped_robot_lies_inside_another() -> None:
    """The first pose of this seed has the feet 34 mm inside each other, which no real robot can have."""
    config = RunConfig(robot="nao-v6", engine="mujoco", seed=82270)
    with build_robot(config) as robot:
        robot.lay_down(random_drop(robot.body, DROP, np.random.default_rng([config.seed, 1])))
        assert robot.engine.robot.overlap() > 0.03
    with dropped(config) as robot:
        assert robot.engine.robot.overlap() < 1e-3


@pytest.mark.parametrize("seed", [88666, 88686], ids=["an arm under the torso", "limp on its feet, leaning"])
def test_a_difficult_drop_stands_up_with_cool_motors(seed: int) -> None:
    drop = get_up(RunConfig(robot="nao-v6", engine="mujoco", seed=seed)).drop
    assert drop.stands
    assert drop.temperature < WARM
