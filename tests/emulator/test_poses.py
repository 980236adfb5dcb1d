"""Poses against scipy's rotations in double precision, and against PyBullet's own functions bit for bit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.quantities import standing_height
from emulator.robot import EmulatedRobot
from emulator.scenarios import START_NAMES
from emulator.start import HOOK_CLEARANCE
from emulator.wear import load_wear

NOMINAL = load_wear("nominal")
UP = {
    "stand": (0.0, 0.0, 1.0),
    "sit": (0.0, 0.0, 1.0),
    "crouch": (0.0, 0.0, 1.0),
    "lie-back": (1.0, 0.0, 0.0),  # face up: the torso's x axis points at the sky
    "lie-front": (-1.0, 0.0, 0.0),
    "lie-side": (0.0, -1.0, 0.0),  # the left arm below
    "hang": (0.0, 0.0, 1.0),
}
"""Direction of the sky in the torso, by the meaning of the words."""


@pytest.mark.parametrize(("body", "engine"), [("nao-v3", "pybullet"), ("nao-v6", "mujoco")])
@pytest.mark.parametrize("name", START_NAMES)
def test_a_pose_points_where_its_name_says_and_rests(body: str, engine: str, name: str) -> None:
    pytest.importorskip(engine)
    with EmulatedRobot(load_body(body), engine=engine, seed=5, wear=NOMINAL, start=name) as robot:
        before = robot.truth()
        for _ in range(100):
            robot.advance(None)
        truth = robot.truth()
        sky = np.array(robot.multibody.state().rotation)[6:9]
    # who leans on hands that are behind the back is between upright and lying
    most = 45.0 if name == "sit" else 25.0
    assert math.acos(min(1.0, float(sky @ UP[name]))) < math.radians(most)
    assert math.dist(before.torso_position, truth.torso_position) < 0.01
    assert truth.fell == (name.startswith("lie") or name == "sit")


def test_a_hanging_robot_is_limp_and_touches_nothing() -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=1, wear=NOMINAL, start="hang") as robot:
        height = robot.truth().torso_position[2]
        assert height == pytest.approx(standing_height(robot.body) + HOOK_CLEARANCE, abs=0.01)
        assert robot.truth().left.force == (0.0, 0.0, 0.0)
        assert set(robot.frame.stiffness) == {0.0}
        robot.stand_up()
        for _ in range(100):
            robot.advance(None)
        truth = robot.truth()
        # off the hook: its feet carry its weight
        assert truth.left.force[2] + truth.right.force[2] == pytest.approx(4.703 * 9.81, rel=0.02)


def test_laid_down_and_put_back_live() -> None:
    with EmulatedRobot(load_body("nao-v6"), seed=1, wear=NOMINAL) as robot:
        for name, pitch in (("lie-back", -math.pi / 2.0), ("lie-front", math.pi / 2.0)):
            robot.lay_down(name)
            for _ in range(150):
                robot.advance(None)
            assert robot.frame.angle[1] == pytest.approx(pitch, abs=0.1)
            assert robot.frame.stiffness[INDEX["LKneePitch"]] == 0.0
        robot.lay_down("stand")
        for _ in range(50):
            robot.advance(None)
        assert not robot.truth().fell
