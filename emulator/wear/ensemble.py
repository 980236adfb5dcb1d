"""Wear profiles, and ensembles: robots that agree with the measurements, and in which unknowns they differ."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.body import Body
from bridge.config import from_dict, load_toml, read_toml
from bridge.errors import ConfigurationError
from emulator.sensors.parameters import SensorParameters
from emulator.servo.parameters import ServoParameters

GENERATION: Final = "generation"
"""Table of a profile with the differences of some bodies, by the beginning of their names."""


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


ENSEMBLE: Final = "ensemble"
_HERE: Final = Path(__file__).parent


class Unknown(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A number that no source gives, and its range."""

    paths: tuple[str, ...] = ()
    """Keys of the wear profile, joined by dots; all are set to one value. None: a condition of an experiment
    that its source does not give."""
    low: float
    high: float
    reason: str
    source: str
    """Source of the range."""
    log: bool = False
    """The range is divided in ratios."""
    calibrated: bool = False
    """The compared measurements depend on it."""
    generation: str = ""
    """Beginning of the names of the bodies that it is for; empty: all."""

    def at(self, share: float) -> float:
        """The value at a share of the range, 0 to 1."""
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + share * (self.high - self.low)

    def share(self, value: float) -> float:
        """The share of the range at which a value is: the inverse of `at`."""
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


class Member(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One robot of an ensemble."""

    values: tuple[float, ...]
    """In the order of `RobotEnsemble.unknowns`, SI units and radians."""
    figures: dict[str, float]
    """Measured on it, by name."""


class RobotEnsemble(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robots, and how they are found."""

    command: str
    engine: str
    seed: int
    """Seed of the draws."""
    tried: int
    """Number of simulated robots."""
    accepted: int
    """Number of these, with every figure within its bounds."""
    unknowns: tuple[str, ...]
    members: tuple[Member, ...]


@functools.cache
def unknowns() -> dict[str, Unknown]:
    """All unknowns by name, in the order of the file."""
    table = read_toml(_HERE / "unknowns.toml")
    return {name: from_dict(entry, f"unknowns.toml: {name}", Unknown) for name, entry in table.items()}


def profile_of(values: Mapping[str, float], name: str, body: Body) -> WearProfile:
    """The nominal profile with other values of some unknowns.

    Args:
        values: By name of the unknown.
        name: Of the profile.
        body: Of the robot.

    Raises:
        ConfigurationError: an impossible value.
    """
    table = read_profile(_HERE / "nominal.toml", body) | {"name": name}
    for key, unknown in unknowns().items():
        if key not in values or not body.base.startswith(unknown.generation):
            continue
        for path in unknown.paths:
            *tables, last = path.split(".")
            functools.reduce(lambda at, key: at[key], tables, table)[last] = values[key]
    return from_dict(table, name, WearProfile)


@functools.cache
def load_ensemble() -> RobotEnsemble:
    """The shipped ensemble; its robots are of all generations."""
    return load_toml(_HERE / "ensemble.toml", RobotEnsemble)


def wear_of_seed(wear: str, seed: int) -> str:
    """The wear of a run: plain `ensemble` selects a member by the seed, one after the other."""
    return f"{ENSEMBLE}:{seed % len(load_ensemble().members)}" if wear == ENSEMBLE else wear


def ensemble_member(name: str, body: Body | None) -> WearProfile:
    """One robot of the ensemble, `ensemble:17`.

    Raises:
        ConfigurationError: no such member, or no body.
    """
    if body is None:
        raise ConfigurationError(f"wear profile {name}: differs between generations; name a robot.")
    ensemble = load_ensemble()
    number = name.partition(":")[2]
    if not (number.isascii() and number.isdecimal()) or int(number) >= len(ensemble.members):
        last = len(ensemble.members) - 1
        raise ConfigurationError(f"wear profile {name}: must be ensemble:0 to ensemble:{last}.")
    values = ensemble.members[int(number)].values
    return profile_of(dict(zip(ensemble.unknowns, values, strict=True)), name, body)
