"""Wear profiles: how far a robot's drives and sensors are from ideal, each effect a number.

A profile is a TOML file; an effect that it does not name stays ideal.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import msgspec

from bridge.config import load_toml
from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from emulator.sensors.parameters import SensorParameters
from emulator.servo.parameters import ServoParameters

WEAR: Final = ("ideal", "nominal", "worn")
"""The profiles that come with the package."""


class WearProfile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Drives and sensors of one robot in one state of wear."""

    name: str
    servo: ServoParameters = ServoParameters()
    sensors: SensorParameters = SensorParameters()


def load_wear(name_or_path: str) -> WearProfile:
    """A shipped profile by name, or one from a TOML file.

    Raises:
        ConfigurationError: no such profile, unknown key, or an impossible value.
    """
    if name_or_path in WEAR:
        return load_toml(Path(__file__).with_name(f"{name_or_path}.toml"), WearProfile)
    if not name_or_path.endswith(".toml"):
        raise ConfigurationError(
            f"{unknown_name('wear profile', name_or_path, WEAR)}, or the path of a .toml file"
        )
    return load_toml(Path(name_or_path), WearProfile)
