"""Motor temperatures, simulated from the current as the robot's own boards do, and the protection by stiffness.

One heat store per motor: temperature - room approaches rise x (torque / nominal torque)^2 with one time
constant. Status 0 is cool; from `warm` (1) the stiffness falls linearly to 70 % at `hot` (2) and from there to
nothing at `critical` (3). The three meanings are the vendor's; the temperatures and the lines between are
assumed.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from emulator.servo.parameters import Heating

Vector = NDArray[np.float64]
HOT_FACTOR: Final = 0.7
"""Factor of the stiffness at status 2 (vendor: lowered by more than 30 %)."""


class MotorHeat:
    """Temperatures of all motors.

    Args:
        heating: Numbers of the model.
        nominal: Torque at each joint that the motor bears for ever, N m.
    """

    def __init__(self, heating: Heating, nominal: Vector) -> None:
        self.active = heating.rise > 0.0
        """Temperatures change at all."""
        self.temperature = np.full(len(nominal), heating.room)
        """Degrees Celsius; may be set from outside (a fault)."""
        self._heating = heating
        self._rise = heating.rise / nominal**2
        self._levels = (heating.warm, heating.hot, heating.critical)

    def update(self, mean_square_torque: Vector, dt: float) -> None:
        """Heat and cool for a while.

        Args:
            mean_square_torque: Of each joint's motor, (n,), (N m)^2.
            dt: s.
        """
        end = self._heating.room + self._rise * mean_square_torque
        self.temperature += (end - self.temperature) * -np.expm1(-dt / self._heating.time_constant)

    @property
    def lowers(self) -> bool:
        """Some motor is hot enough for the protection to act."""
        return bool(self.temperature.max() > self._levels[0])

    def stiffness_factor(self) -> Vector:
        """Factor by which the protection lowers each requested stiffness."""
        return np.asarray(np.interp(self.temperature, self._levels, (1.0, HOT_FACTOR, 0.0)))

    def status(self) -> list[int]:
        """0 cool, 1 stiffness lowered, 2 by more than 30 %, 3 none left."""
        levels: list[int] = np.searchsorted(self._levels, self.temperature, side="right").tolist()
        return levels
