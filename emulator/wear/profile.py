"""The type of a wear profile, and how one is read for a body."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.body import Body
from bridge.config import from_dict, read_toml
from bridge.errors import ConfigurationError
from emulator.sensors.parameters import SensorParameters
from emulator.servo.parameters import ServoParameters

GENERATION: Final = "generation"
"""Table of a profile with what differs on some bodies, by the beginning of their names."""


class WearProfile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Drives and sensors of one robot in one state of wear."""

    name: str
    servo: ServoParameters = ServoParameters()
    sensors: SensorParameters = SensorParameters()


def read_profile(path: Path, body: Body | None) -> dict[str, Any]:
    """Tables of a profile for a body: those of all bodies, changed by those of its generation.

    Args:
        path: TOML file.
        body: None: as it is for bodies of no named generation.

    Raises:
        ConfigurationError: not readable, or a generation that does not fit the profile.
    """
    table = read_toml(path)
    generations = table.pop(GENERATION, {})
    if not isinstance(generations, dict) or not all(isinstance(each, dict) for each in generations.values()):
        raise ConfigurationError(f"{path}: {GENERATION} must be tables by the beginning of a body's name.")
    for begin, changes in generations.items():
        changed = merged(table, changes)
        from_dict(changed, f"{path}: {GENERATION}.{begin}", WearProfile)
        if body is not None and body.base.startswith(begin):
            table = changed
    return table


def merged(table: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """A table with changes, table by table."""
    both = dict(table)
    for key, value in changes.items():
        both[key] = merged(both.get(key, {}), value) if isinstance(value, dict) else value
    return both
