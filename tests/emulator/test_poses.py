"""Poses against scipy's rotations in double precision, and against PyBullet's own functions bit for bit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.quantities import standing_height
from bridge.errors import ConfigurationError
from emulator.engine.pybullet.client import bullet
from emulator.poses import ORIGIN, Pose, compose, inverse, matrix, point_of, quaternion, yaw_of
from emulator.robot import EmulatedRobot
from emulator.scenarios import FLAT, START_NAMES
from emulator.scenarios.ground import Start
from emulator.scenarios.model import Scenario
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


def random_pose(rng: np.random.Generator, size: float) -> Pose:
    """With a rotation of about this size."""
    q = np.append(size * rng.normal(size=3), 1.0)
    return Pose(tuple(rng.normal(size=3).tolist()), tuple((q / np.linalg.norm(q)).tolist()))


@pytest.mark.parametrize("size", [0.0, 0.01, 1.0, 100.0])
def test_composition_and_inverse(size: float) -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        a, b = random_pose(rng, size), random_pose(rng, size)
        turn, found = Rotation.from_quat(a.orientation), compose(a, b)
        np.testing.assert_allclose(found.position, turn.apply(b.position) + a.position, atol=1e-14)
        turned = turn * Rotation.from_quat(b.orientation)
        np.testing.assert_allclose(
            np.reshape(matrix(found.orientation), (3, 3)), turned.as_matrix(), atol=1e-14
        )
        assert point_of(a, b.position) == found.position
        there_and_back = compose(inverse(a), a)
        np.testing.assert_allclose(there_and_back.position, ORIGIN.position, atol=1e-14)
        np.testing.assert_allclose(there_and_back.orientation, ORIGIN.orientation, atol=1e-14)
        assert matrix(a.orientation) == bullet.getMatrixFromQuaternion(a.orientation)
    assert inverse(ORIGIN) == ORIGIN


def test_roll_pitch_yaw() -> None:
    rng = np.random.default_rng(4)
    for roll, pitch, yaw in rng.uniform(-1.5, 1.5, (200, 3)).tolist():
        q = quaternion(roll, pitch, yaw)
        np.testing.assert_allclose(
            q, Rotation.from_euler("ZYX", (yaw, pitch, roll)).as_quat(canonical=True), atol=1e-12
        )
        assert yaw_of(q) == pytest.approx(yaw, abs=1e-12)
        assert q == bullet.getQuaternionFromEuler((roll, pitch, yaw))


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


def test_a_scenario_names_the_pose_and_a_wrong_one_is_refused() -> None:
    with EmulatedRobot(load_body("nao-v3"), seed=1, scenario=Scenario(start=Start(pose="lie-back"))) as robot:
        assert robot.truth().fell
    with pytest.raises(ConfigurationError, match="lie-bak"):
        EmulatedRobot(load_body("nao-v3"), seed=1, scenario=FLAT, start="lie-bak")
