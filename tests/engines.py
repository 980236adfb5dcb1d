"""Physics engines as tests use them: robots without drives, and quantities that only tests ask for."""

from __future__ import annotations

from typing import Any

import numpy as np

from bridge.body import Body, joint_tree
from emulator.drives import Drives
from emulator.engine.base import Engine, Multibody


def passive(body: Body, rotor_inertia: float = 0.003) -> Drives:
    """Drives without torque; every rotor has this inertia at its joint, kg m^2."""
    return Drives(np.full(len(joint_tree(body)), rotor_inertia))


def bare_step(engine: Engine) -> None:
    """The engine's own time step alone, nothing applied and nothing read: the floor of a benchmark."""
    asked: Any = engine
    if hasattr(engine, "simulation"):
        import mujoco

        mujoco.mj_step(asked.simulation.model, asked.simulation.data)
        asked.simulation.moved()
    else:
        import pybullet

        pybullet.stepSimulation(asked.client)


def energy(engine: Engine, robot: Multibody) -> float:
    """Kinetic energy, rotors included, and potential energy over the world's origin, J, of the one robot."""
    asked: Any = engine
    masses = np.array([robot.body.links[link].mass for link in ("Torso", *robot.joints)])
    if hasattr(engine, "simulation"):
        import mujoco

        model, data = asked.simulation.model, asked.simulation.now
        mujoco.mj_crb(model, data)
        momentum = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, momentum, data.qvel)
        kinetic = 0.5 * float(data.qvel @ momentum)
        return kinetic + engine.settings.gravity * float(masses.sum()) * robot.com()[2]
    return _of_pybullet(asked, robot) + engine.settings.gravity * float(masses.sum()) * robot.com()[2]


def _of_pybullet(engine: Any, robot: Any) -> float:
    """Kinetic energy of each link about its own principal axes, R^T omega; the rotors are in the links."""
    import pybullet

    client, number = engine.client, robot.model.robot
    total = 0.0
    for link, mass in zip((-1, *robot.model.numbers), robot.model.masses, strict=True):
        inertia = np.array(pybullet.getDynamicsInfo(number, link, physicsClientId=client)[2])
        if link == -1:
            turn = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)[1]
            velocity, spin = pybullet.getBaseVelocity(number, physicsClientId=client)
        else:
            options = {"computeLinkVelocity": True, "computeForwardKinematics": True}
            found = pybullet.getLinkState(number, link, **options, physicsClientId=client)
            turn, velocity, spin = found[1], found[6], found[7]
        local = np.reshape(pybullet.getMatrixFromQuaternion(turn), (3, 3)).T @ spin
        total += 0.5 * mass * float(np.square(velocity).sum()) + 0.5 * float(inertia @ np.square(local))
    return total
