"""Monitor of the motors' temperatures and the battery's charge."""

from __future__ import annotations

from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS
from bridge.body.quantities import absent_joints
from bridge.guard.config import BatterySettings, TemperatureSettings
from bridge.messages import SensorFrame
from bridge.messages.guard import Reason


class SupplyMonitor:
    """Temperature and charge, each with a warning, a limit, and a way back.

    Args:
        body: data sheet; joints it lacks have no temperature.
        temperature: bounds of the hottest motor.
        battery: bounds of the charge.
    """

    def __init__(self, body: Body, temperature: TemperatureSettings, battery: BatterySettings) -> None:
        absent = absent_joints(body)
        self._slots = [INDEX[joint] for joint in JOINTS if joint not in absent]
        self._heat, self._charge = temperature, battery
        self._hot = self._empty = False
        self._warned_heat = self._warned_charge = False

    @property
    def fault(self) -> Reason:
        """What is beyond its limit and not yet back; empty: nothing."""
        return "temperature" if self._hot else "battery" if self._empty else ""

    def update(self, frame: SensorFrame) -> list[str]:
        """One cycle; the warnings of this cycle, one sentence each."""
        warnings = []
        slot = max(self._slots, key=frame.temperature.__getitem__)
        heat, charge = frame.temperature[slot], frame.battery[0]
        if heat >= self._heat.warn and not self._warned_heat:
            warnings.append(
                f"{JOINTS[slot]} is at {heat:.0f} degrees Celsius; at {self._heat.limit:g} the robot goes down."
            )
        self._warned_heat = heat >= self._heat.warn or (self._warned_heat and heat >= self._heat.resume)
        self._hot = heat >= self._heat.limit or (self._hot and heat >= self._heat.resume)
        if charge <= self._charge.warn and not self._warned_charge:
            warnings.append(f"The battery is at {charge:.0%}; at {self._charge.limit:.0%} the robot goes down.")
        self._warned_charge = charge <= self._charge.warn
        self._empty = charge <= self._charge.limit or (self._empty and charge <= self._charge.resume)
        return warnings
