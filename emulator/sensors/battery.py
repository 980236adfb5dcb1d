"""The battery: charge, current and temperature."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from emulator.sensors.parameters import BatteryParameters

DISCHARGING: Final = 0.0
"""Status word without the charging bit 0x80."""
SECONDS_PER_HOUR: Final = 3600.0


class Battery:
    """Runs down with the current that the computers and motors draw.

    The motors' currents count in full, as if their boards passed the battery's voltage on (assumed: an upper
    bound, less is drawn while they chop it). A gauge only: an empty battery does not switch the robot off.

    Args:
        parameters: Its numbers.
        cycle: Time between two updates, s.
    """

    def __init__(self, parameters: BatteryParameters, cycle: float) -> None:
        p = parameters
        self._per_ampere = cycle * p.voltage / (p.energy * SECONDS_PER_HOUR) if p.energy > 0.0 else 0.0
        self._idle, self._heating, self._room = p.idle_current, p.heating, p.room
        self._share = min(1.0, cycle / p.heating_time)
        self.charge = p.charge
        """0..1; may be set from outside."""
        self.temperature = p.room
        """Degrees Celsius; may be set from outside."""
        self._current = 0.0

    def update(self, motor_currents: Iterable[float]) -> None:
        """One cycle.

        Args:
            motor_currents: One per motor, A.
        """
        current = self._idle + sum(motor_currents)
        self._current = -current
        self.charge = max(0.0, self.charge - current * self._per_ampere)
        target = self._room + self._heating * current * current
        self.temperature += self._share * (target - self.temperature)

    def read(self) -> tuple[float, float, float, float]:
        """Charge 0..1, current A (negative: flows out), status, temperature in degrees Celsius."""
        return self.charge, self._current, DISCHARGING, self.temperature
