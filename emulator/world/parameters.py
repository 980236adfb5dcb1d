"""How finely PyBullet computes the world."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class WorldParameters:
    """Physics settings; all assumed but gravity."""

    step: float = 0.001
    """Physics and servo step, s."""
    gravity: float = 9.81
    """m/s^2"""
    friction: float = 0.8
    """Coulomb coefficient between soles and floor (hard rubber on a carpeted or wooden floor); a scenario may
    have its own."""
    solver_iterations: int = 50
    """Upper bound of the contact solver's sweeps per step; it stops earlier when converged."""
    solver_residual: float = 1e-10
    """Converged when the squared change of all impulses is below this. PyBullet's own 1e-7 leaves a standing
    robot's contact forces alternating by 0.3 % from step to step; 1e-10 leaves 3e-5 and costs 8 % of a step."""
