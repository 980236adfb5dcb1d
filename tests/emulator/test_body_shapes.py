"""The shell of the robot: what may touch, what may not, and that a heap of limp limbs only loses energy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import BODIES, joint_tree, load_body
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.postures import POSTURES
from emulator.engine.base import Engine
from emulator.engine.catalogue import open_engine
from emulator.engine.settings import PhysicsSettings
from emulator.engine.shapes import FOOT_LINKS, CapsuleShape, SphereShape, link_shapes
from emulator.poses import ORIGIN, Pose, matrix
from emulator.world.world import WOOD
from tests.engines import energy, passive

DROP = 0.6
"""m; the Torso frame's height: about 0.2 m of free fall, more for a curled robot."""


@pytest.fixture
def engine() -> Iterator[Engine]:
    opened = open_engine("pybullet", PhysicsSettings())
    yield opened
    opened.close()


def _random_angles(engine: Engine, body_name: str, random: np.random.Generator) -> None:
    """Joint angles over the whole ranges, and no limbs in one another."""
    sheet, (robot,) = load_body(body_name).joints, engine.robots
    names = robot.joints
    for _ in range(50):
        q = {name: random.uniform(sheet[name].lower, sheet[name].upper) for name in names}
        q["RHipYawPitch"] = q["LHipYawPitch"]
        robot.place(ORIGIN, joints=[q[name] for name in names])
        if engine.overlap(robot, robot) == 0.0:
            return
    pytest.fail("50 random poses, and limbs in one another in each")


@pytest.mark.parametrize(("body", "seed"), [("nao-v3", 100), ("nao-v6", 101)])
def test_energy_of_a_limp_robot_only_falls(engine: Engine, body: str, seed: int) -> None:
    # no drive, no source of energy: kinetic and potential energy together can only get less
    random = np.random.default_rng(seed)
    engine.surround(engine.surroundings._replace(surface=WOOD))
    robot = engine.add_robot(load_body(body), passive(load_body(body)))
    _random_angles(engine, body, random)
    x, y, z, w = Rotation.random(random_state=random).as_quat()
    robot.place(Pose((0.0, 0.0, DROP), (x, y, z, w)))
    energies, deepest = [energy(engine, robot)], 0.0
    for step in range(2500):
        engine.run(1)
        energies.append(energy(engine, robot))
        if step % 50 == 0:
            deepest = max(deepest, engine.overlap(robot, robot))
    rises = np.array(energies) - np.minimum.accumulate(energies)
    # What the springs under the soles give back, and the solver while it pushes overlapping shapes apart.
    assert rises.max() < 2e-2 * energies[0]
    assert energies[-1] < 0.2 * energies[0]
    assert deepest < 0.003


def _lowest(engine: Engine, body_name: str) -> tuple[float, float]:
    """Lowest point of the soles, and of all rounded shapes, world frame, m."""
    body, (robot,) = load_body(body_name), engine.robots
    lowest = np.inf
    for link, shape in link_shapes(body).items():
        if not isinstance(shape, CapsuleShape | SphereShape):
            continue
        position, turn = robot.state(link).pose
        rotation = np.array(matrix(turn)).reshape(3, 3)
        half = 0.5 * shape.length if isinstance(shape, CapsuleShape) else 0.0
        axis = Rotation.from_quat(shape.orientation).as_matrix()[:, 2] if half else np.zeros(3)
        for end in (-half, half):
            z = position[2] + rotation[2] @ (np.array(shape.centre) + end * axis)
            lowest = min(lowest, float(z) - shape.radius)
    soles = []
    for link in FOOT_LINKS.values():
        position, turn = robot.state(link).pose
        soles.append(position[2] - body.lengths.FootHeight * matrix(turn)[8])
    return min(soles), lowest


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("posture", ["StandInit", "Crouch"])
def test_only_the_soles_of_a_robot_on_its_feet_reach_the_ground(
    engine: Engine, body: str, posture: str
) -> None:
    robot = engine.add_robot(load_body(body), passive(load_body(body)))
    robot.place(ORIGIN, joints=[POSTURES[posture][INDEX_WITH_MIRROR[name]] for name in robot.joints])
    sole, shell = _lowest(engine, body)
    assert shell > sole + 0.005
    if posture != "Crouch":  # there the published one lays the hands on the thighs
        assert engine.overlap(robot, robot) == 0.0


@pytest.mark.parametrize("body", ["nao-v3", "nao-v6"])
def test_feet_do_not_stand_inside_each_other(engine: Engine, body: str) -> None:
    # both hips rolled inward as far as they go, the feet press on each other instead of passing through
    names = list(joint_tree(load_body(body)))
    robot = engine.add_robot(load_body(body), passive(load_body(body)), held=True)
    torque = robot.torque
    torque[names.index("LHipRoll")], torque[names.index("RHipRoll")] = -0.5, 0.5
    engine.surround(engine.surroundings._replace(gravity=(0.0, 0.0, 0.0)))
    robot.place(Pose((0.0, 0.0, 1.0)))
    deepest = 0.0
    for step in range(1000):
        engine.run(1)
        if step % 10 == 0:
            deepest = max(deepest, engine.overlap(robot, robot))
    left, right = (robot.state(link).position[1] for link in FOOT_LINKS.values())
    assert deepest < 0.003
    assert left - right > 0.06  # the inner edges of the two soles, 33 and 39 mm from the ankles
