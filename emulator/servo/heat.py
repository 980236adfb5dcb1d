"""Motor temperatures, simulated from the current as the robot's own boards do, and the protection by stiffness.

One heat store per motor: temperature - room approaches rise x (torque / nominal torque)^2 with one time
constant. Status 0 is cool; from `warm` (1) the stiffness falls linearly to 70 % at `hot` (2) and from there to
nothing at `critical` (3). The three meanings are the vendor's; the temperatures and the lines between are
assumed.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from bridge.types import Array, Vec3
from emulator.compiled import compiled
from emulator.servo.parameters import Heating

HOT_FACTOR: Final = 0.7
"""Factor of the stiffness at status 2 (vendor: lowered by more than 30 %)."""


class MotorHeat:
    """Temperatures of all motors.

    Args:
        heating: Numbers of the model.
        nominal: Torque at each joint that the motor bears for ever, N m.
    """

    def __init__(self, heating: Heating, nominal: Array) -> None:
        self.active = heating.rise > 0.0
        """Temperatures change at all."""
        self.temperature = np.full(len(nominal), heating.room)
        """Degrees Celsius; may be set from outside (a fault)."""
        self._heating = heating
        self._rise = heating.rise / nominal**2
        self.levels = (heating.warm, heating.hot, heating.critical)
        """At which the status changes, degrees Celsius."""

    def update(self, mean_square_torque: Array, dt: float) -> None:
        """Heat and cool for a while.

        Args:
            mean_square_torque: Of each joint's motor, (n,), (N m)^2.
            dt: s.
        """
        gain = -math.expm1(-dt / self._heating.time_constant)
        _approach(self.temperature, mean_square_torque, self._rise, self._heating.room, gain)

    def status(self) -> list[int]:
        """0 cool, 1 stiffness lowered, 2 by more than 30 %, 3 none left."""
        levels: list[int] = np.searchsorted(self.levels, self.temperature, side="right").tolist()
        return levels


@compiled
def _approach(temperature: Array, square: Array, rise: Array, room: float, gain: float) -> None:
    for i in range(len(temperature)):
        temperature[i] += (room + rise[i] * square[i] - temperature[i]) * gain


@compiled
def stiffness_factor(temperature: float, levels: Vec3) -> float:
    """Factor by which the protection lowers a requested stiffness.

    Args:
        temperature: Of the motor, degrees Celsius.
        levels: `MotorHeat.levels`.
    """
    warm, hot, critical = levels
    if temperature < warm:
        return 1.0
    if temperature < hot:
        return (HOT_FACTOR - 1.0) / (hot - warm) * (temperature - warm) + 1.0
    if temperature < critical:
        return (0.0 - HOT_FACTOR) / (critical - hot) * (temperature - hot) + HOT_FACTOR
    return 0.0
