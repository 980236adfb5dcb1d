"""What the guard sees in the sensor frames: a fall, heat, an empty battery, and whether the legs hold."""

from __future__ import annotations

import math
from typing import Final

from bridge.datasheet import Body
from bridge.datasheet.quantities import absent_joints
from bridge.guard.config import BatterySettings, FallSettings, TemperatureSettings
from bridge.joints import INDEX, JOINTS, LEG_SLOTS
from bridge.messages import SensorFrame

_STIFF: Final = 0.2
"""A robot whose legs all have less stiffness does not stand by them."""


def lean(frame: SensorFrame) -> float:
    """Angle between the torso and the vertical by the fused angle, rad.

    AngleX and AngleY are taken for roll and pitch: cos(lean) = cos(roll) cos(pitch).
    """
    roll, pitch = frame.angle
    return math.acos(max(-1.0, min(1.0, math.cos(roll) * math.cos(pitch))))


def legs_stiff(stiffness: tuple[float, ...]) -> bool:
    """Whether the legs hold the robot."""
    return min(stiffness[slot] for slots in LEG_SLOTS.values() for slot in slots) >= _STIFF


class FallWatch:
    """Is the robot falling? By the fused angle, for some cycles; once per fall.

    Args:
        settings: the bounds.
    """

    def __init__(self, settings: FallSettings) -> None:
        self._s = settings
        self._leaning = 0
        self._may_fall = True

    def update(self, frame: SensorFrame) -> bool:
        """One cycle; True in the one in which a fall is noticed.

        A robot that has fallen must have stood upright before it can fall again, so that it may get up.
        """
        angle = lean(frame)
        self._may_fall = self._may_fall or angle < self._s.upright
        self._leaning = self._leaning + 1 if angle > self._s.angle else 0
        falls = self._s.enabled and self._may_fall and self._leaning >= self._s.cycles
        self._may_fall = self._may_fall and not falls
        return falls


class Supplies:
    """Heat and charge, each with a warning, a limit, and a way back.

    Args:
        body: data sheet; joints it lacks have no temperature.
    """

    def __init__(self, body: Body, temperature: TemperatureSettings, battery: BatterySettings) -> None:
        absent = absent_joints(body)
        self._slots = [INDEX[joint] for joint in JOINTS if joint not in absent]
        self._heat, self._charge = temperature, battery
        self.hot = self.empty = False
        """Beyond the limit, and not yet back."""
        self._warned_heat = self._warned_charge = False

    def update(self, frame: SensorFrame) -> list[str]:
        """One cycle; sentences to say."""
        said = []
        slot = max(self._slots, key=frame.temperature.__getitem__)
        heat, charge = frame.temperature[slot], frame.battery[0]
        if heat >= self._heat.warn and not self._warned_heat:
            said.append(f"{JOINTS[slot]} is at {heat:.0f} degrees Celsius; at {self._heat.limit:g} it ends.")
        self._warned_heat = heat >= self._heat.warn or (self._warned_heat and heat >= self._heat.resume)
        self.hot = heat >= self._heat.limit or (self.hot and heat >= self._heat.resume)
        if charge <= self._charge.warn and not self._warned_charge:
            said.append(f"The battery is at {charge:.0%}; at {self._charge.limit:.0%} it ends.")
        self._warned_charge = charge <= self._charge.warn
        self.empty = charge <= self._charge.limit or (self.empty and charge <= self._charge.resume)
        return said
