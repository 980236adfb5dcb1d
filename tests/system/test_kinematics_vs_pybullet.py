"""The walker's kinematics against the link frames and masses of the emulator's PyBullet model.

PyBullet's interface passes single precision in places: 3e-8 m was seen, 1e-6 is asked for.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import BODIES, TORSO, joint_tree, load_body
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS, N_JOINTS
from bridge.body.kinematics import CentreOfMass, homogeneous

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
