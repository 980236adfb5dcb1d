"""The multibody against an independent product of exponentials and an independent mass matrix."""

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from bridge.body import BODIES, TORSO, Body, joint_tree, load_body
from emulator.engine.pybullet.client import bullet, connect, disconnect
from emulator.engine.pybullet.model import BulletModel, build_model

Matrix = NDArray[np.float64]


@pytest.fixture
def client() -> Iterator[int]:
    number = connect()
    yield number
    disconnect(number)


def skew(v: Matrix) -> Matrix:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def chain(body: Body, joint: str) -> list[str]:
    tree, names = joint_tree(body), []
    for _ in tree:
        if joint == TORSO:
            break
        names.append(joint)
        joint = tree[joint].parent
    return names[::-1]


def origin(body: Body, joint: str) -> Matrix:
    """Zero-pose joint origin in the Torso frame."""
    tree = joint_tree(body)
    return np.sum([tree[name].offset for name in chain(body, joint)], axis=0)


def frame(body: Body, joint: str, angles: dict[str, float]) -> Matrix:
    """Joint frame in the Torso frame: exp(S1 q1) exp(S2 q2) ... M, screws in the Torso frame."""
    result = np.eye(4)
    for name in chain(body, joint):
        axis = np.array(joint_tree(body)[name].axis)
        screw = np.zeros((4, 4))
        screw[:3, :3] = skew(axis)
        screw[:3, 3] = np.cross(origin(body, name), axis)
        result = result @ expm(screw * angles[name])
    home = np.eye(4)
    home[:3, 3] = origin(body, joint)
    return np.asarray(result @ home)


def random_pose(body: Body, model: BulletModel, rng: np.random.Generator) -> dict[str, float]:
    angles = {n: float(rng.uniform(body.joints[n].lower, body.joints[n].upper)) for n in model.joints}
    for i, name in zip(model.numbers, model.joints, strict=True):
        bullet.resetJointState(model.robot, i, angles[name], physicsClientId=model.client)
    return angles


def inertia(body: Body, joint: str, rotor: float) -> Matrix:
    ixx, iyy, izz, ixy, ixz, iyz = body.links[joint].inertia
    tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    if joint == TORSO:
        return tensor
    axis = np.array(joint_tree(body)[joint].axis)
    return tensor + rotor * np.outer(axis, axis)


def mass_matrix(body: Body, joints: tuple[str, ...], angles: dict[str, float], rotor: float) -> Matrix:
    """Joint-space mass matrix with the torso at rest, from each link's Jacobian."""
    total = np.zeros((len(joints), len(joints)))
    for name in joints:
        pose = frame(body, name, angles)
        com = pose[:3, :3] @ body.links[name].com + pose[:3, 3]
        linear, angular = np.zeros((3, len(joints))), np.zeros((3, len(joints)))
        for parent in chain(body, name):
            base = frame(body, parent, angles)
            axis = base[:3, :3] @ np.array(joint_tree(body)[parent].axis)
            i = joints.index(parent)
            angular[:, i] = axis
            linear[:, i] = np.cross(axis, com - base[:3, 3])
        tensor = pose[:3, :3] @ inertia(body, name, rotor) @ pose[:3, :3].T
        total += body.links[name].mass * linear.T @ linear + angular.T @ tensor @ angular
    return total


@pytest.mark.parametrize("name", BODIES)
def test_link_frames_and_centres_of_mass(name: str, client: int) -> None:
    body = load_body(name)
    model = build_model(client, body, rotor_inertia=[0.004] * len(joint_tree(body)))
    rng = np.random.default_rng(7)
    for _ in range(2):
        angles = random_pose(body, model, rng)
        links = bullet.getLinkStates(
            model.robot, model.numbers, computeForwardKinematics=True, physicsClientId=client
        )
        for joint, link in zip(model.joints, links, strict=True):
            expected = frame(body, joint, angles)
            rotation = np.array(bullet.getMatrixFromQuaternion(link[5])).reshape(3, 3)
            np.testing.assert_allclose(link[4], expected[:3, 3], atol=1e-6)
            np.testing.assert_allclose(rotation, expected[:3, :3], atol=1e-6)
            com = expected[:3, :3] @ body.links[joint].com + expected[:3, 3]
            np.testing.assert_allclose(link[0], com, atol=1e-6)


@pytest.mark.parametrize("name", ["nao-v3", "nao-v6"])
def test_mass_matrix_honours_the_full_tensors(name: str, client: int) -> None:
    body = load_body(name)
    model = build_model(client, body, rotor_inertia=[0.0] * len(joint_tree(body)))
    rng = np.random.default_rng(8)
    n = len(model.joints)
    for _ in range(1):
        angles = random_pose(body, model, rng)
        matrix = np.array(
            bullet.calculateMassMatrix(model.robot, list(angles.values()), physicsClientId=client)
        )[-n:, -n:]
        expected = mass_matrix(body, model.joints, angles, 0.0)
        np.testing.assert_allclose(matrix, expected, atol=1e-6 * np.abs(expected).max())


def test_rotor_inertia_acts_about_the_joint_axes(client: int) -> None:
    body = load_body("nao-v3")
    rotor, dt = 0.004, 1e-5
    model = build_model(client, body, rotor_inertia=[rotor] * len(joint_tree(body)), fixed=True)
    for gear in range(bullet.getNumConstraints(physicsClientId=client)):
        bullet.removeConstraint(bullet.getConstraintUniqueId(gear, physicsClientId=client), client)
    rng = np.random.default_rng(9)
    angles = random_pose(body, model, rng)
    n = len(model.joints)
    torque = rng.normal(size=n) * 1e-3
    bullet.setTimeStep(dt, physicsClientId=client)
    for mode, forces in ((bullet.VELOCITY_CONTROL, np.zeros(n)), (bullet.TORQUE_CONTROL, torque)):
        bullet.setJointMotorControlArray(
            model.robot, model.numbers, mode, forces=forces.tolist(), physicsClientId=client
        )
    bullet.stepSimulation(physicsClientId=client)
    states = bullet.getJointStates(model.robot, model.numbers, physicsClientId=client)
    acceleration = np.array([state[1] for state in states]) / dt
    expected = np.linalg.solve(mass_matrix(body, model.joints, angles, rotor), torque)
    np.testing.assert_allclose(acceleration, expected, atol=1e-4 * np.abs(expected).max())
