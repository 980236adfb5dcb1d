"""The battery: charge, current and temperature."""

from __future__ import annotations

from typing import Final

from emulator.sensors.parameters import BatteryParameters

DISCHARGING: Final = 0.0
CHARGING: Final = 128.0
"""Status words: bit 0x80 says that it is being charged."""
SECONDS_PER_HOUR: Final = 3600.0


class Battery:
    """Runs down with the current that the computers and motors draw, unless the robot is on its charger.

    A gauge only: an empty battery does not switch the robot off.

    Args:
        parameters: Its numbers.
        energy: Of a full one as good as new, W h.
        cycle: Time between two updates, s.
        charger: The charger supplies the current; the charge stays.
    """

    def __init__(
        self, parameters: BatteryParameters, energy: float, cycle: float, *, charger: bool = False
    ) -> None:
        p = parameters
        holds = p.capacity * energy * SECONDS_PER_HOUR
        self._per_ampere = cycle * p.voltage / holds if holds > 0.0 and not charger else 0.0
        self._status = CHARGING if charger else DISCHARGING
        self._idle, self._heating, self._room = p.idle_current, p.heating, p.room
        self._gain = min(1.0, cycle / p.heating_time)
        self.charge = p.charge
        """0..1; may be set from outside."""
        self.temperature = p.room
        """Degrees Celsius; may be set from outside."""
        self._current = 0.0

    def update(self, motors: float) -> None:
        """One cycle.

        Args:
            motors: What all motors draw, A.
        """
        current = self._idle + motors
        self._current = -current
        self.charge = max(0.0, self.charge - current * self._per_ampere)
        target = self._room + self._heating * current * current
        self.temperature += self._gain * (target - self.temperature)

    def read(self) -> tuple[float, float, float, float]:
        """Charge 0..1, current A (negative: flows out), status, temperature in degrees Celsius."""
        return self.charge, self._current, self._status, self.temperature
