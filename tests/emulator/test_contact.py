"""Soles on a surface against the closed forms of an evenly pressed rectangle on a bed of springs.

One foot of a robot without weight is pressed on the floor by a force of its own; the rest hangs on it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from bridge.body import Body, joint_tree, load_body
from bridge.body.quantities import joint_no_load_speed
from bridge.body.sole import sole_hull
from bridge.messages import ActuatorFrame
from bridge.types import Vec3
from emulator.engine.base import Engine
from emulator.engine.catalogue import open_engine
from emulator.engine.mujoco.engine import MujocoEngine
from emulator.engine.pybullet.client import bullet
from emulator.engine.settings import PhysicsSettings
from emulator.engine.shapes import FOOT_LINKS
from emulator.poses import Pose, compose, matrix, quaternion
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from emulator.world.world import SURFACES, World
from tests.engines import passive

LOAD = 47.0
"""N, about the weight of a NAO."""


def mean_distance(length: float, width: float) -> float:
    """Of the points of a rectangle from its middle, closed form, m."""
    a, b = length, width
    d = math.hypot(a, b)
    return (d + a * a / (2 * b) * math.log((b + d) / a) + b * b / (2 * a) * math.log((a + d) / b)) / 6.0


def sides(body: Body) -> tuple[float, float]:
    """Length and width of a sole, m."""
    length, width = np.ptp(sole_hull(body, "L"), axis=0)
    return float(length), float(width)


class PressedFoot:
    """A left foot that is pressed on the floor.

    Args:
        body: Data sheet.
        surface: Of the floor, by name.
        pitch: Of the foot at first, rad.
    """

    def __init__(self, engine: Engine, body: Body, surface: str, pitch: float = 0.0) -> None:
        self.engine = engine
        World(self.engine, SURFACES[surface])
        self.engine.surround(self.engine.surroundings._replace(gravity=(0.0, 0.0, 0.0)))
        self.robot = robot = self.engine.add_robot(body, passive(body, 1e-3))
        outline = sole_hull(body, "L")
        middle = 0.5 * (outline.max(axis=0) + outline.min(axis=0))
        self._middle: Vec3 = (float(middle[0]), float(middle[1]), -body.lengths.FootHeight)
        # the right leg out of the way, the left sole just over the floor
        raised = {"RHipPitch": -0.8, "RKneePitch": 1.6}
        joints = [raised.get(name, 0.0) for name in robot.joints]
        robot.place(Pose(orientation=quaternion(pitch=pitch)), joints=joints)
        lowest = min(self.world((x, y, -body.lengths.FootHeight))[2] for x, y in outline.tolist())
        robot.place(Pose((0.0, 0.0, -lowest), quaternion(pitch=pitch)))

    def world(self, point: Vec3) -> Vec3:
        """A point of the AnkleRoll frame in the world."""
        return compose(self.robot.state(FOOT_LINKS["L"]).pose, Pose(point)).position

    def height(self) -> float:
        """Of the sole's middle over the floor, m."""
        return self.world(self._middle)[2]

    def step(self, torque: Vec3, along: float = 0.0) -> None:
        """One step under a torque (world frame, N m), the load `along` metres in front of the sole's middle."""
        x, y, _ = self._middle
        place, force = self.world((x + along, y, 0.0)), (0.0, 0.0, -LOAD)
        if isinstance(self.engine, MujocoEngine):
            com = self.robot.link_com(FOOT_LINKS["L"])
            moment = np.cross(np.subtract(place, com), force) + torque
            self.engine.simulation.data.body(f"1/{FOOT_LINKS['L']}").xfrc_applied[:] = (*force, *moment)
        else:
            self._push_bullet(place, force, torque)
        self.engine.run(1)

    def _push_bullet(self, place: Vec3, force: Vec3, torque: Vec3) -> None:
        bullet = pytest.importorskip("emulator.engine.pybullet.client").bullet
        model = self.robot.model
        link, options = model.feet["L"], {"flags": bullet.WORLD_FRAME, "physicsClientId": model.client}
        bullet.applyExternalForce(model.robot, link, force, place, **options)
        bullet.applyExternalTorque(model.robot, link, torque, **options)

    def angles(self) -> tuple[float, float]:
        """Pitch and yaw of the foot, rad."""
        turn = matrix(self.robot.state(FOOT_LINKS["L"]).pose.orientation)
        return math.asin(-turn[6]), math.atan2(turn[3], turn[0])


def breakaway(foot: PressedFoot) -> float:
    """Torque about the vertical at which the foot begins to turn, N m; at most 6."""
    for _ in range(500):
        foot.step((0.0, 0.0, 0.0))
    start = foot.angles()[1]
    for torque in np.arange(0.0, 6.0, 2e-3):
        foot.step((0.0, 0.0, float(torque)))
        if abs(foot.angles()[1] - start) > math.radians(0.2):
            return float(torque)
    raise AssertionError("it does not turn")


@pytest.fixture
def engine(physics: str) -> Iterator[Engine]:
    found = open_engine(physics, PhysicsSettings())
    yield found
    found.close()


@pytest.mark.parametrize("surface", SURFACES)
def test_a_flat_sole_resists_a_turn_as_a_patch_does(engine: Engine, surface: str) -> None:
    """Coulomb under even pressure: friction x load x mean distance from the middle."""
    body = load_body("nao-v3")
    foot = PressedFoot(engine, body, surface)
    expected = SURFACES[surface].friction * LOAD * mean_distance(*sides(body))
    assert breakaway(foot) == pytest.approx(expected, rel=0.10)


@pytest.mark.parametrize("surface", SURFACES)
def test_a_sole_sinks_as_a_bed_of_springs_says(engine: Engine, surface: str) -> None:
    """Depth = load / (stiffness_per_area x area), and 25 um of PyBullet's own."""
    body = load_body("nao-v3")
    length, width = sides(body)
    foot = PressedFoot(engine, body, surface)
    for _ in range(1000):
        foot.step((0.0, 0.0, 0.0))
    expected = LOAD / (SURFACES[surface].stiffness_per_area * length * width)
    own = 0.0 if isinstance(engine, MujocoEngine) else 2.5e-5
    assert -foot.height() == pytest.approx(expected, rel=0.03, abs=own)


@pytest.mark.parametrize("surface", ["carpet", "turf"])
def test_a_sole_tilts_under_a_load_off_its_middle_as_a_bed_of_springs_does(
    engine: Engine, surface: str
) -> None:
    """Angle = load x arm / (stiffness_per_area x second moment of the rectangle), inside the kern.

    PyBullet chooses the points of the outline that carry, which costs up to 40 %.
    """
    body = load_body("nao-v3")
    length, width = sides(body)
    arm = length / 7.0
    foot = PressedFoot(engine, body, surface)
    pitch = []
    for along in (-arm, arm):
        for _ in range(1500):
            foot.step((0.0, 0.0, 0.0), along)
        pitch.append(foot.angles()[0])
    expected = LOAD * 2.0 * arm / (SURFACES[surface].stiffness_per_area * width * length**3 / 12.0)
    error = 0.03 if isinstance(engine, MujocoEngine) else 0.45
    assert pitch[1] - pitch[0] == pytest.approx(expected, rel=error)


@pytest.mark.parametrize(
    ("name", "wear", "physics"),
    [("nao-v6", "ideal", "mujoco"), ("nao-v3", "nominal", "mujoco"), ("nao-v6", "worn", "pybullet")],
)
def test_random_requests_and_falls_leave_the_joints_within_a_degree_of_their_stops(
    name: str, wear: str, physics: str
) -> None:
    pytest.importorskip(physics)
    body = load_body(name)
    random = np.random.default_rng(1)
    with EmulatedRobot(body, engine=physics, seed=0, wear=load_wear(wear)) as robot:
        joints = robot.multibody
        sheets = [body.joints[joint] for joint in joints.joints]
        lower, upper = (np.array([getattr(sheet, end) for sheet in sheets]) for end in ("lower", "upper"))
        beyond, speed, height = 0.0, 0.0, 0.0
        for k in range(500):
            command = None
            if k % 20 == 0:
                command = ActuatorFrame(
                    reply_to=k,
                    position=tuple(random.uniform(-2.5, 2.5, 25).tolist()),
                    stiffness=tuple(random.uniform(-0.2, 1.0, 25).tolist()),
                )
            robot.advance(command)
            assert np.isfinite(joints.position).all()
            beyond = max(beyond, float((joints.position - upper).max()), float((lower - joints.position).max()))
            truth = robot.truth()
            speed = max(speed, float(np.linalg.norm(truth.torso_velocity)))
            height = max(height, truth.com[2])
        assert robot.truth().fell
    assert math.degrees(beyond) < 1.0
    # no faster than a fall from standing, and no higher than a jump that no NAO can do
    assert speed < math.sqrt(2.0 * 9.81 * 0.35)
    assert height < 0.40


def kinetic_energy(robot: EmulatedRobot) -> float:
    """Of all links, from PyBullet's own velocities and inertias, J."""
    model = robot.multibody.model
    client, body = model.client, model.robot
    turn = bullet.getBasePositionAndOrientation(body, physicsClientId=client)[1]
    moving = [(-1, turn, *bullet.getBaseVelocity(body, physicsClientId=client))]
    links = model.numbers
    for link, state in zip(links, bullet.getLinkStates(body, links, 1, 1, physicsClientId=client), strict=True):
        moving.append((link, state[1], state[6], state[7]))
    energy = 0.0
    for link, turn, velocity, omega in moving:
        info = bullet.getDynamicsInfo(body, link, physicsClientId=client)
        own = np.array(bullet.getMatrixFromQuaternion(turn)).reshape(3, 3).T @ omega
        energy += 0.5 * info[0] * float(np.dot(velocity, velocity)) + 0.5 * float(np.dot(info[2], own**2))
    return energy


@pytest.mark.parametrize("wear", ["ideal", "worn"])
def test_a_limp_robot_flung_in_weightlessness_gains_no_energy(wear: str) -> None:
    body = load_body("nao-v6")
    random = np.random.default_rng(1)
    with EmulatedRobot(body, seed=0, wear=load_wear(wear), settle=0.0, lift=1.0) as robot:
        client = robot.multibody.model.client
        bullet.setGravity(0.0, 0.0, 0.0, physicsClientId=client)
        limp = ActuatorFrame(reply_to=0, position=(0.0,) * 25, stiffness=(-1.0,) * 25)
        for _ in range(5):
            robot.advance(limp)
        numbers = robot.multibody.model.numbers
        for i, joint in enumerate(joint_tree(body)):
            speed = joint_no_load_speed(body, joint) * float(random.uniform(-1.0, 1.0))
            angle = float(robot.multibody.position[i])
            bullet.resetJointState(
                robot.multibody.model.robot, numbers[i], angle, speed, physicsClientId=client
            )
        energies = []
        for _ in range(200):
            energies.append(kinetic_energy(robot))
            robot.advance(None)
    assert energies[0] > 1.0
    assert max(np.diff(energies)) < 2e-3 * energies[0]
    assert energies[-1] < 0.5 * energies[0]
