"""The world: gravity, a floor, and how finely PyBullet computes it."""

from __future__ import annotations

from dataclasses import dataclass

from emulator.engine import bullet


@dataclass(frozen=True)
class WorldParameters:
    """Physics settings; all assumed but gravity."""

    step: float = 0.001
    """Physics and servo step, s."""
    gravity: float = 9.81
    """m/s^2"""
    friction: float = 0.8
    """Coulomb coefficient between soles and floor (hard rubber on a carpeted or wooden floor)."""
    solver_iterations: int = 50
    """Upper bound of the contact solver's sweeps per step; it stops earlier when converged."""
    solver_residual: float = 1e-10
    """Converged when the squared change of all impulses is below this. PyBullet's own 1e-7 leaves a standing
    robot's contact forces alternating by 0.3 % from step to step; 1e-10 leaves 3e-5 and costs 8 % of a step."""


@dataclass(frozen=True)
class World:
    """A physics client with a floor."""

    client: int
    floor: int
    """PyBullet's number of the floor."""
    parameters: WorldParameters


def build_world(client: int, parameters: WorldParameters) -> World:
    """Set up gravity and a floor at z = 0 in an empty physics client."""
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=parameters.step,
        numSubSteps=0,
        numSolverIterations=parameters.solver_iterations,
        solverResidualThreshold=parameters.solver_residual,
        deterministicOverlappingPairs=1,
        physicsClientId=client,
    )
    bullet.setGravity(0.0, 0.0, -parameters.gravity, physicsClientId=client)
    shape = bullet.createCollisionShape(bullet.GEOM_PLANE, planeNormal=(0.0, 0.0, 1.0), physicsClientId=client)
    floor = int(bullet.createMultiBody(0.0, shape, physicsClientId=client))
    bullet.changeDynamics(
        floor, -1, lateralFriction=parameters.friction, restitution=0.0, physicsClientId=client
    )
    return World(client, floor, parameters)
