"""The linear inverted pendulum (Prenner 2011, 3.4): a centre of mass at constant height over its ZMP."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

from bridge.types import Array
from walker.model.gravity import GRAVITY
from walker.planning.polynomial import MotionState

Number = TypeVar("Number", float, Array)


@dataclass(frozen=True, slots=True)
class LinearPendulum:
    """One horizontal direction at a time; both obey the same equation x'' = nu^2 (x - x_zmp)."""

    height: float
    """Of the centre of mass above the ground, m."""

    @property
    def nu(self) -> float:
        """Natural frequency sqrt(g / z), 1/s (3.10)."""
        return math.sqrt(GRAVITY / self.height)

    def zmp(self, position: Number, acceleration: Number) -> Number:
        """Zero moment point (3.4), m.

        Args:
            position: of the centre of mass, m, any shape.
            acceleration: of the centre of mass, m/s^2, of the same shape.
        """
        return position - acceleration * self.height / GRAVITY

    def motion(self, t: float, position: float, velocity: float) -> MotionState:
        """Motion of the centre of mass while the zero moment point rests at 0 (3.10).

        Args:
            t: s, before or after the moment at which the state is given.
            position: of the centre of mass at t = 0, m.
            velocity: there, m/s.
        """
        nu = self.nu
        sinh, cosh = math.sinh(nu * t), math.cosh(nu * t)
        a, b = position, velocity / nu
        return MotionState(
            a * cosh + b * sinh,
            a * nu * sinh + b * nu * cosh,
            a * nu**2 * cosh + b * nu**2 * sinh,
        )

    def capture_point(self, position: float, velocity: float) -> float:
        """Where the zero moment point must rest for the centre of mass to come to rest above it, m.

        Args:
            position: of the centre of mass, m.
            velocity: of the centre of mass, m/s.
        """
        return position + velocity / self.nu
