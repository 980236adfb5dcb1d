"""A campaign in a file: a base, axes, and seeds."""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, Final

import msgspec

from bridge.config import from_dict, load_toml
from bridge.errors import ConfigurationError
from emulator.scenarios import load_scenario
from nao_hil.analysis.statistics import share_of
from nao_hil.campaigns.quantities import changed_all
from nao_hil.runs.build import with_engine
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk, WalkEnd

MAX_CELLS: Final = 100_000
"""Combinations of the axes' values."""


class CampaignFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The walks of a campaign: every combination of the axes' values, with every seed."""

    base: dict[str, Any] = {}
    """As in a configuration file; `scenario` is the world."""
    axes: dict[str, Annotated[tuple[Any, ...], msgspec.Meta(min_length=1)]] = {}
    """Values by quantity, see `quantities.changed`."""
    seeds: Annotated[int, msgspec.Meta(ge=1)] = 20
    first_seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    duration: Annotated[float, msgspec.Meta(gt=0.0)] = 10.0
    """Duration of a walk, s."""
    keep_track: bool = False

    def with_defaults(self) -> CampaignFile:
        """The same with every value of the base, and the engine by the name that it has on this machine."""
        base = with_engine(from_dict(self.base, "base", RunConfig))
        return msgspec.structs.replace(self, base=msgspec.to_builtins(base))

    def cells(self) -> list[tuple[dict[str, Any], Walk]]:
        """Each combination with its walk of the first seed.

        Raises:
            ConfigurationError: an unknown quantity or an impossible value.
        """
        config = from_dict(self.base, "base", RunConfig)
        for name, values in self.axes.items():
            if any(value in values[:i] for i, value in enumerate(values)):
                raise ConfigurationError(f"axes: {name} has a value twice; it would be compared with itself.")
        count = math.prod(len(values) for values in self.axes.values())
        if count > MAX_CELLS:
            raise ConfigurationError(f"axes: {count} combinations; at most {MAX_CELLS} are walked.")
        cells = []
        for values in itertools.product(*self.axes.values()):
            point = dict(zip(self.axes, values, strict=True))
            task = Walk(
                name=", ".join(f"{name} {value}" for name, value in point.items()) or "base",
                config=config,
                duration=self.duration,
                scenario=load_scenario(config.scenario),
                keep_track=self.keep_track,
            )
            try:
                task = changed_all(task, point)
            except ConfigurationError as error:
                raise ConfigurationError(f"axes: {error}") from None
            cells.append((point, task))
        return cells

    def walks(self, cells: Iterable[tuple[dict[str, Any], Walk]]) -> Iterator[Walk]:
        """All walks, seed by seed, so that a stop leaves about as many of each combination."""
        tasks = [task for _, task in cells]
        for seed in range(self.first_seed, self.first_seed + self.seeds):
            for task in tasks:
                yield with_seed(task, seed)


def with_seed(task: Walk, seed: int) -> Walk:
    """The same walk with another seed."""
    return msgspec.structs.replace(task, config=msgspec.structs.replace(task.config, seed=seed))


def load_campaign(file: Path) -> CampaignFile:
    """Read a campaign.

    Raises:
        ConfigurationError: unreadable, an unknown key, or an impossible value.
    """
    asked = load_toml(file, CampaignFile)
    if not (asked.base or asked.axes):
        raise ConfigurationError(
            f"{file}: no tables `base` and `axes`; give the quantities that the walks vary."
        )
    return asked


class CampaignCell:
    """One combination, counted as its walks end."""

    def __init__(self, point: dict[str, Any]) -> None:
        self.point = point
        self.ends: dict[int, WalkEnd] = {}
        """By seed."""

    def summary(self) -> dict[str, Any]:
        """For JSON; the interval is Wilson's, 95 %."""
        share = share_of([end.survived for end in self.ends.values()])
        speeds = [end.speed for end in self.ends.values()]
        return {"point": self.point, **msgspec.structs.asdict(share)} | {
            "speed": statistics.median(speeds) if speeds else None
        }
