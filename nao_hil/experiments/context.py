"""Context of an experiment: robot, wear, seeds, changed parameters, folder; makes walks and runs them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, zip_longest
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple, TypeVar

import msgspec

from bridge.body import Body, load_body
from emulator.wear import wear_of_seed
from nao_hil.analysis.statistics import wilson
from nao_hil.campaigns.quantities import changed_all
from nao_hil.runs.campaign import Campaign, Interrupted
from nao_hil.runs.config import Engine, RunConfig
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.parameters import controller_parameters
from walker.switches import differing

Result = TypeVar("Result")
Key = TypeVar("Key")

BLOCK: Final = 5
"""Seeds that `Context.run_until_certain` walks between two looks."""
NO_CHANGE: Final[Mapping[str, Any]] = MappingProxyType({})


def seed_words(seeds: Sequence[int]) -> str:
    """`0 to 19 (20)`, or the list where it has gaps."""
    if len(seeds) > 1 and list(seeds) == list(range(seeds[0], seeds[0] + len(seeds))):
        return f"{seeds[0]} to {seeds[-1]} ({len(seeds)})"
    return ", ".join(map(str, seeds))


class Task(NamedTuple):
    """Walks that are made in several conditions."""

    gait: str
    duration: float
    """Duration of a walk, s."""
    changes: Mapping[str, Any] = NO_CHANGE
    """Values by quantity (`nao_hil.campaigns.quantities`), such as `controller.switches.torso`."""
    by_seed: Callable[[Walk], Mapping[str, Any]] = lambda _: NO_CHANGE
    """Further fields of a `Walk`, drawn from its seed."""
    fields: Mapping[str, Any] = NO_CHANGE
    """More of `Walk`."""

    def walks(self, context: Context, name: str, changes: Mapping[str, Any] = NO_CHANGE) -> list[Walk]:
        """The walks of a condition, one per seed.

        Args:
            context: Robot and seeds.
            name: Of the condition.
            changes: Of the condition, besides those of the task.

        Raises:
            ConfigurationError: an unknown quantity or an impossible value.
        """
        base = Walk(name=name, config=context.config(self.gait), duration=self.duration, **self.fields)
        base = changed_all(base, {**self.changes, **changes})
        walks = []
        for seed in context.seeds:
            config = msgspec.structs.replace(base.config, seed=seed, wear=wear_of_seed(base.config.wear, seed))
            walk = msgspec.structs.replace(base, config=config)
            walks.append(msgspec.structs.replace(walk, **self.by_seed(walk)))
        return walks

    def each(
        self, name: str, conditions: Mapping[str, Mapping[str, Any]]
    ) -> Callable[[Context], dict[str, list[Walk]]]:
        """The walks of an experiment by the conditions' names; each condition is its changes."""
        return lambda context: {
            condition: self.walks(context, f"{name}, {condition}", changes)
            for condition, changes in conditions.items()
        }


@dataclass(frozen=True)
class Context:
    """Everything that an experiment depends on except its own numbers."""

    campaign: Campaign
    out: Path
    """Folder for JSON and figures."""
    seeds: tuple[int, ...]
    changes: RunConfig
    """Robot, wear, engine, and the changed parameters of one gait and controllers; no more of it is read."""
    duration: float | None = None
    """s of one run, where an experiment takes one; None: its own."""
    gait: str | None = None
    """Name, where an experiment takes one; None: its own."""

    @property
    def robot(self) -> str:
        """Name or path of the body."""
        return self.changes.robot

    @property
    def wear(self) -> str:
        """Name or path of the wear profile; `ensemble`: a member for each seed, see `config`."""
        return self.changes.wear

    @property
    def engine(self) -> Engine:
        """Name of the physics engine."""
        return self.changes.engine

    @property
    def body(self) -> Body:
        """Data sheet of the robot."""
        return load_body(self.robot)

    def first(self, n: int) -> Context:
        """The same with the first few seeds only."""
        return replace(self, seeds=self.seeds[:n])

    def on(self, **fields: Any) -> Context:
        """The same on another robot, wear or engine."""
        return replace(self, changes=msgspec.structs.replace(self.changes, **fields))

    def configs(self, **fields: Any) -> list[RunConfig]:
        """The changes with each seed, and other fields of a configuration."""
        return [msgspec.structs.replace(self.changes, seed=seed, **fields) for seed in self.seeds]

    def config(self, gait: str) -> RunConfig:
        """Base configuration of a gait's walks; the changed parameters hold for their own gait."""
        same = gait == self.changes.gait
        return RunConfig(
            robot=self.robot,
            wear=self.wear,
            engine=self.engine,
            gait=gait,
            steps=0,
            parameters=self.changes.parameters if same else {},
            controller=self.changes.controller if same else {},
        )

    def map(
        self, name: str, function: Callable[[Any], Any], tasks: Sequence[Any], *, whole: bool = False
    ) -> list[Any]:
        """A function's results for tasks, in their order; fewer after a stop.

        Args:
            name: Of the measurement.
            function: At the top level of a module.
            tasks: One for each call.
            whole: The results count only together.

        Raises:
            Interrupted: no task is done; with `whole`: stopped before the last.
        """
        return _complete(self.campaign.map(name, function, tasks), len(tasks) if whole else 1)

    def walk_all(self, walks: Sequence[Walk]) -> list[WalkOutcome]:
        """Walks that count only together.

        Raises:
            Interrupted: stopped before the last walk.
        """
        return _complete(self.campaign.walk(walks), len(walks))

    def walk_by_name(self, walks: Sequence[Walk]) -> dict[str, list[WalkOutcome]]:
        """Outcomes by the name of their walks; after a stop of the finished ones.

        Raises:
            Interrupted: none is done.
        """
        by_name: dict[str, list[WalkOutcome]] = {}
        for outcome in _complete(self.campaign.walk(walks), 1):
            by_name.setdefault(outcome.walk.name, []).append(outcome)
        return by_name

    def run(self, conditions: Mapping[Key, Sequence[Walk]]) -> dict[Key, list[WalkOutcome]]:
        """Walk several conditions in one go, seed by seed, so that a stop leaves about as many of each.

        Each condition differs in one switch at most from the one before it, or in the gait with all that is the
        gait's own: so one difference explains the results.

        Args:
            conditions: Walks by a key of the condition.

        Raises:
            Interrupted: stopped before each condition had a run.
            ValueError: two neighbouring conditions differ in more than that.
            NaoHilError: a configuration that cannot be walked, or a run that failed.
        """
        for one, other in pairwise(conditions.values()):
            _check_one_difference(one[0], other[0])
        mixed = [walk for of_seed in zip_longest(*conditions.values()) for walk in of_seed if walk]
        done = {(result.walk.name, result.seed): result for result in self.campaign.walk(mixed)}
        results = {
            key: [done[k] for w in walks if (k := (w.name, w.config.seed)) in done]
            for key, walks in conditions.items()
        }
        if not all(results.values()):
            raise Interrupted
        return results

    def run_until_certain(
        self, share: float, conditions: Mapping[Key, Sequence[Walk]]
    ) -> dict[Key, list[WalkOutcome]]:
        """As `run`, a block of seeds at a time; a condition ends when further seeds cannot change its verdict.

        The verdict is whether the lower bound of Wilson's interval of the share that stands, with all seeds
        walked, is `share` or more. Ending early changes no verdict (curtailed sampling). With so few seeds that
        not even all of them could reach it, all are walked.

        Args:
            share: 0..1.
            conditions: As in `run`, all with the same seeds.
        """
        if wilson(len(self.seeds), len(self.seeds))[0] < share:
            return self.run(conditions)
        results: dict[Key, list[WalkOutcome]] = {key: [] for key in conditions}
        for begin in range(0, len(self.seeds), BLOCK):
            open_ = {
                key: walks[begin : begin + BLOCK]
                for key, walks in conditions.items()
                if not _certain(results[key], len(self.seeds), share)
            }
            if not open_:
                break
            for key, found in self.run(open_).items():
                results[key] += found
        return results


def _complete(results: list[Result], least: int) -> list[Result]:
    if len(results) < least:
        raise Interrupted
    return results


def _certain(found: Sequence[WalkOutcome], seeds: int, share: float) -> bool:
    """Whether the verdict is the same if all other seeds stand and if all others fall."""
    stood = sum(result.end.survived for result in found)
    return wilson(stood + seeds - len(found), seeds)[0] < share or wilson(stood, seeds)[0] >= share


def _check_one_difference(one: Walk, other: Walk) -> None:
    if one.config.gait != other.config.gait:
        if one.config.controller != other.config.controller:
            raise ValueError(f"conditions {one.name} and {other.name} differ in the gait and in the controller")
        return
    switches = (controller_parameters(w.config.gait, w.config.controller).switches for w in (one, other))
    if len(names := differing(*switches)) > 1:
        raise ValueError(
            f"conditions {one.name} and {other.name} differ in {len(names)} switches: {', '.join(names)}"
        )
