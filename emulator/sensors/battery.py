"""The battery: charge, current and temperature."""

from __future__ import annotations

from typing import Final

from emulator.sensors.parameters import BatteryParameters

DISCHARGING: Final = 0x0028
"""Status word without a charger: it discharges (0x20), its discharge transistor is on (0x08)."""
CHARGING: Final = 0x8088
"""Status word on the charger: it is supplied (0x8000) and charged (0x80). The bits are as a ROS driver names
them, and agree with a captured packet of a robot on its charger, 0x80d8."""
FULL: Final = 0x0040
"""Bit of a full battery."""
FULL_FROM: Final = 0.985
"""Charge from which that bit is set (assumed; the captured packet has it at 0.99)."""
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
        self._state = CHARGING if charger else DISCHARGING
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
        return self.charge, self._current, self._status(), self.temperature

    def _status(self) -> float:
        """The status word as robots send it: a signed 16 bit integer in a float."""
        word = self._state | (FULL if self.charge >= FULL_FROM else 0)
        return float(word - 0x10000 if word & 0x8000 else word)
