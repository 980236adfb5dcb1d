"""The type of a wear profile."""

from __future__ import annotations

import msgspec

from emulator.sensors.parameters import SensorParameters
from emulator.servo.parameters import ServoParameters


class WearProfile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Drives and sensors of one robot in one state of wear."""

    name: str
    servo: ServoParameters = ServoParameters()
    sensors: SensorParameters = SensorParameters()
