"""Kinematics and Huang's zero moment point against the emulator's PyBullet model.

PyBullet's interface passes single precision in places: 3e-8 m was seen, 1e-6 is asked for.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import BODIES, TORSO, joint_tree, load_body
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.body.kinematics import CentreOfMass, homogeneous
from walker.gaits.huang.multibody import Ankle, Bodies
from walker.gaits.pose import ARMS

pytest.importorskip("pybullet")

from emulator.engine.pybullet.client import bullet, connect, disconnect
from emulator.engine.pybullet.model import BASE, build_model


@pytest.fixture
def client():
    number = connect()
    yield number
    disconnect(number)


def pose(position, quaternion):
    return homogeneous(Rotation.from_quat(quaternion).as_matrix(), position)


def random_state(body, rng):
    """Joint positions inside their ranges, and a pose for the torso."""
    low = [body.joints[j].lower if j in body.joints else 0.0 for j in JOINTS]
    high = [body.joints[j].upper if j in body.joints else 0.0 for j in JOINTS]
    return rng.uniform(low, high, N_JOINTS), rng.uniform(-1.0, 1.0, 3), Rotation.from_quat(rng.normal(size=4))


def place_robot(model, position, torso_place, torso_turn):
    """Set all joints and the torso's inertial frame, which is what PyBullet moves."""
    for i, joint in zip(model.numbers, model.joints, strict=True):
        slot = INDEX_WITH_MIRROR[joint]
        bullet.resetJointState(model.robot, i, position[slot], physicsClientId=model.client)
    bullet.resetBasePositionAndOrientation(
        model.robot, torso_place, torso_turn.as_quat(), physicsClientId=model.client
    )


def frames_and_com(model):
    """Link frames in the Torso frame by name, and the centre of mass there, from PyBullet's own answers."""
    robot, client = model.robot, model.client
    masses = [bullet.getDynamicsInfo(robot, i, physicsClientId=client)[0] for i in (BASE, *model.numbers)]
    base = bullet.getBasePositionAndOrientation(robot, physicsClientId=client)
    inertial_in_torso = pose(*bullet.getDynamicsInfo(robot, BASE, physicsClientId=client)[3:5])
    torso_in_world = pose(*base) @ np.linalg.inv(inertial_in_torso)
    world_in_torso = np.linalg.inv(torso_in_world)
    frames, coms = {TORSO: np.eye(4)}, [np.array(base[0])]
    for i, joint in zip(model.numbers, model.joints, strict=True):
        state = bullet.getLinkState(robot, i, computeForwardKinematics=1, physicsClientId=client)
        coms.append(np.array(state[0]))
        frames[joint] = world_in_torso @ pose(*state[4:6])
    com_in_world = np.average(coms, axis=0, weights=masses)
    return frames, (world_in_torso @ [*com_in_world, 1.0])[:3], sum(masses)


@pytest.mark.parametrize("name", BODIES)
def test_link_frames_and_com_are_pybullets(client, name):
    body = load_body(name)
    model = build_model(client, body, rotor_inertia=[0.0] * len(joint_tree(body)))
    com = CentreOfMass(body)
    rng = np.random.default_rng(41)
    for _ in range(100 if name == "nao-v3" else 20):
        position, torso_place, torso_turn = random_state(body, rng)
        place_robot(model, position, torso_place, torso_turn)
        theirs, their_com, their_mass = frames_and_com(model)
        ours = com.tree.link_frames(position)
        assert set(ours) == set(theirs)
        for link, frame in ours.items():
            assert frame == pytest.approx(theirs[link], abs=1e-6), link
        assert com(position) == pytest.approx(their_com, abs=1e-6)
        assert com.mass == pytest.approx(their_mass, abs=1e-6)


STEP, SETTLE, END = 1e-3, 0.8, 2.2
"""s"""
REACH = 25
"""Steps before and after: a second difference is the mean of the acceleration over this reach either way, with
weights that fall off evenly; the reaction is averaged alike."""
WEIGHTS = np.bartlett(2 * REACH + 1) / REACH


def hip(time: float) -> tuple[float, float, float]:
    """A sway along all axes at once, begun gently."""
    share = min(time / SETTLE, 1.0) ** 3
    return (
        0.02 + share * 0.012 * math.sin(2.0 * math.pi * 1.1 * time),
        share * 0.02 * math.sin(2.0 * math.pi * 0.9 * time),
        0.2 + share * 0.006 * math.sin(2.0 * math.pi * 1.6 * time),
    )


def test_against_the_ground_reaction(client) -> None:
    body = load_body("nao-v3")
    bodies, an = Bodies(body, ARMS), body.lengths.FootHeight
    left, right = Ankle(0.0, 0.05, an, 0.0), Ankle(0.0, -0.05, an, 0.0)
    floor = bullet.createMultiBody(
        baseCollisionShapeIndex=bullet.createCollisionShape(bullet.GEOM_PLANE, physicsClientId=client),
        physicsClientId=client,
    )
    bullet.changeDynamics(floor, -1, lateralFriction=1.0, physicsClientId=client)
    bullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
    bullet.setTimeStep(STEP, physicsClientId=client)
    model = build_model(client, body, rotor_inertia=[0.0] * 22)
    start = bodies.joint_angles(hip(0.0), left, right)
    for i, name in zip(model.numbers, model.joints, strict=True):
        bullet.resetJointState(model.robot, i, start[INDEX_WITH_MIRROR[name]], physicsClientId=client)
    place, turn = bullet.multiplyTransforms(
        (hip(0.0)[0], 0.0, hip(0.0)[2] + body.lengths.HipOffsetZ),
        (0.0, 0.0, 0.0, 1.0),
        model.torso_com,
        model.torso_principal,
    )
    bullet.resetBasePositionAndOrientation(model.robot, place, turn, physicsClientId=client)
    order = [bodies.links.index(name) for name in model.joints]
    frames, moments = [], []
    for k in range(round(END / STEP)):
        angles = bodies.joint_angles(hip((k + 1) * STEP), left, right)
        targets = [angles[INDEX_WITH_MIRROR[name]] for name in model.joints]
        bullet.setJointMotorControlArray(
            model.robot,
            model.numbers,
            bullet.POSITION_CONTROL,
            targetPositions=targets,
            positionGains=[0.3] * len(targets),
            velocityGains=[1.0] * len(targets),
            forces=[200.0] * len(targets),
            physicsClientId=client,
        )
        bullet.stepSimulation(physicsClientId=client)
        loads = [(p[9], *p[5][:2]) for p in bullet.getContactPoints(model.robot, floor, physicsClientId=client)]
        moments.append(
            [sum(f for f, _, _ in loads), sum(f * x for f, x, _ in loads), sum(f * y for f, _, y in loads)]
        )
        frames.append(_frames(model, order, len(bodies.links)))
    reaction, placed = np.array(moments), np.array(frames)
    found, expected, still = [], [], []
    for k in range(round(SETTLE / STEP), len(placed) - REACH, 7):
        around = placed[k - REACH], placed[k], placed[k + REACH]
        found.append(bodies.zmp(*around, step=REACH * STEP))
        force, along, across = WEIGHTS @ reaction[k - REACH : k + REACH + 1]
        expected.append((along / force, across / force))
        still.append(bodies.centre_of_mass(placed[k])[:2])
    apart = np.sqrt(np.mean((np.array(found) - np.array(expected)) ** 2, axis=0))
    moving = np.sqrt(np.mean((np.array(still) - np.array(expected)) ** 2, axis=0))
    assert moving.min() > 0.01  # the mass' place alone is no answer
    assert apart.max() < 0.0015  # what is left is the soles' chatter on the floor
    assert apart.max() < 0.1 * moving.min()


def _frames(model, order, count) -> np.ndarray:
    """All link frames in the world frame, in the order of the walker's tree."""
    placed = np.zeros((count, 4, 4))
    where, turn = bullet.getBasePositionAndOrientation(model.robot, physicsClientId=model.client)
    inertial = bullet.invertTransform(model.torso_com, model.torso_principal)
    place, turn = bullet.multiplyTransforms(where, turn, *inertial)
    placed[0] = homogeneous(Rotation.from_quat(turn).as_matrix(), place)
    states = bullet.getLinkStates(
        model.robot, model.numbers, computeForwardKinematics=1, physicsClientId=model.client
    )
    for row, state in zip(order, states, strict=True):
        placed[row] = homogeneous(Rotation.from_quat(state[5]).as_matrix(), state[4])
    return placed
