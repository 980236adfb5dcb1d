"""Stops: nothing passes them, nothing gains energy from them."""

import math

import numpy as np
import pytest

from bridge.body import joint_tree, load_body
from bridge.body.quantities import joint_no_load_speed
from bridge.messages import ActuatorFrame
from emulator.engine.contacts import Stops, own_inertia
from emulator.engine.pybullet.client import bullet
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear


def test_a_lone_link_arrives_at_its_stop_in_one_step() -> None:
    body, joints = load_body("nao-v6"), ("LWristYaw", "RWristYaw")
    rotor = np.array([1e-4, 1e-4])
    stops = Stops(body, joints, rotor, 0.001)
    inertia = rotor + [own_inertia(body, joint) for joint in joints]
    upper = body.joints["LWristYaw"].upper
    position, velocity = np.array([upper - 0.005, -upper + 0.002]), np.array([20.0, -20.0])
    torque = np.zeros(2)
    stops.brake(position, velocity, torque)
    after = position + (velocity + torque / inertia * 0.001) * 0.001
    np.testing.assert_allclose(after, (upper, body.joints["RWristYaw"].lower), atol=1e-9)
    free = np.zeros(2)
    stops.brake(np.array([0.0, 0.5]), velocity, free)
    assert free.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(("name", "wear"), [("nao-v6", "ideal"), ("nao-v3", "nominal"), ("nao-v6", "worn")])
def test_random_requests_and_falls_leave_the_joints_within_a_degree_of_their_stops(
    name: str, wear: str, physics: str
) -> None:
    body = load_body(name)
    random = np.random.default_rng(1)
    with EmulatedRobot(body, engine=physics, seed=0, wear=load_wear(wear)) as robot:
        joints = robot.engine.robot
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
    model = robot.engine.robot.model
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


@pytest.mark.parametrize("wear", ["ideal", "nominal", "worn"])
def test_a_limp_robot_flung_in_weightlessness_gains_no_energy(wear: str) -> None:
    body = load_body("nao-v6")
    random = np.random.default_rng(1)
    with EmulatedRobot(body, seed=0, wear=load_wear(wear), settle=0.0, lift=1.0) as robot:
        client = robot.engine.robot.model.client
        bullet.setGravity(0.0, 0.0, 0.0, physicsClientId=client)
        limp = ActuatorFrame(reply_to=0, position=(0.0,) * 25, stiffness=(-1.0,) * 25)
        for _ in range(5):
            robot.advance(limp)
        numbers = robot.engine.robot.model.numbers
        for i, joint in enumerate(joint_tree(body)):
            speed = joint_no_load_speed(body, joint) * float(random.uniform(-1.0, 1.0))
            angle = float(robot.engine.robot.position[i])
            bullet.resetJointState(
                robot.engine.robot.model.robot, numbers[i], angle, speed, physicsClientId=client
            )
        energies = []
        for _ in range(200):
            energies.append(kinetic_energy(robot))
            robot.advance(None)
    assert energies[0] > 1.0
    assert max(np.diff(energies)) < 2e-3 * energies[0]
    assert energies[-1] < 0.5 * energies[0]
