"""Robots that agree with what is published, and the unknowns in which they differ."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.body import Body
from bridge.config import from_dict, load_toml, read_toml
from bridge.errors import ConfigurationError
from emulator.wear.profile import WearProfile

ENSEMBLE: Final = "ensemble"
_HERE: Final = Path(__file__).parent
GENERATIONS: Final = {"nao-v3": "nao-v3", "nao-v4": "nao-v5", "nao-v5": "nao-v5", "nao-v6": "nao-v6"}
"""Body whose ensemble a body has, by the beginning of its name; V4 and V5 share one."""


class Unknown(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A parameter of the nominal wear profile that no source gives, and where it may lie."""

    paths: tuple[str, ...]
    """Keys of the wear profile, joined by dots; all are set to one value."""
    low: float
    high: float
    reason: str
    source: str
    """Of the range."""
    log: bool = False
    """The range is divided in ratios."""

    def at(self, share: float) -> float:
        """The value at a share of the range, 0 to 1."""
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + share * (self.high - self.low)


class Member(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One robot of an ensemble."""

    values: tuple[float, ...]
    """In the order of `RobotEnsemble.unknowns`, SI units and radians."""
    figures: dict[str, float]
    """Of its torso step, by the fields of the experiment's result."""


class RobotEnsemble(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Robots of one generation, and how they were found."""

    command: str
    robot: str
    engine: str
    seed: int
    """Of the draws."""
    drawn: int
    """Points of the ranges."""
    tried: int
    """Of these, robots that were simulated: those that a linear model did not rule out."""
    unknowns: tuple[str, ...]
    members: tuple[Member, ...]


@functools.cache
def unknowns() -> dict[str, Unknown]:
    """All unknowns by name, in the order of the file."""
    table = read_toml(_HERE / "unknowns.toml")
    return {name: from_dict(entry, f"unknowns.toml: {name}", Unknown) for name, entry in table.items()}


def profile_of(values: Mapping[str, float], name: str) -> WearProfile:
    """The nominal profile with other values of some unknowns.

    Args:
        values: By name of the unknown.
        name: Of the profile.

    Raises:
        ConfigurationError: an impossible value.
    """
    table: dict[str, Any] = read_toml(_HERE / "nominal.toml") | {"name": name}
    for unknown, value in values.items():
        for path in unknowns()[unknown].paths:
            *tables, last = path.split(".")
            functools.reduce(lambda at, key: at[key], tables, table)[last] = value
    return from_dict(table, name, WearProfile)


@functools.cache
def load_ensemble(robot: str) -> RobotEnsemble:
    """The shipped ensemble of a body's generation.

    Args:
        robot: Name of the body.

    Raises:
        ConfigurationError: none is shipped.
    """
    for begin, generation in GENERATIONS.items():
        file = _HERE / "ensembles" / f"{generation}.toml"
        if robot.startswith(begin) and file.exists():
            return load_toml(file, RobotEnsemble)
    raise ConfigurationError(
        f"wear profile ensemble: none is there for {robot}; see `nao-hil design ensemble`."
    )


def wear_of_seed(wear: str, body: Body, seed: int) -> str:
    """The wear of a run: `ensemble` alone stands for all members, one after the other by the seed."""
    if wear != ENSEMBLE:
        return wear
    return f"{ENSEMBLE}:{seed % len(load_ensemble(body.name).members)}"


def ensemble_member(name: str, body: Body | None) -> WearProfile:
    """One robot of the ensemble of a body, `ensemble:17`.

    Raises:
        ConfigurationError: no such member, or no body.
    """
    if body is None:
        raise ConfigurationError(f"wear profile {name}: each generation has its own; name a robot.")
    ensemble = load_ensemble(body.name)
    number = name.partition(":")[2]
    if not (number.isascii() and number.isdecimal()) or int(number) >= len(ensemble.members):
        last = len(ensemble.members) - 1
        raise ConfigurationError(f"wear profile {name}: must be ensemble:0 to ensemble:{last} for {body.name}.")
    values = ensemble.members[int(number)].values
    return profile_of(dict(zip(ensemble.unknowns, values, strict=True)), name)
