"""What every experiment is given: robot, wear, seeds, changed parameters, a campaign, and a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, zip_longest
from pathlib import Path
from typing import Any, Final, TypeAlias

import msgspec

from bridge.messages.world import PlateUnderFoot
from emulator.wear import wear_of_seed
from nao_hil.analysis.statistics import wilson
from nao_hil.runs.campaign import Campaign, Interrupted
from nao_hil.runs.config import Engine, RunConfig
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.parameters import controller_parameters, merged
from walker.switches import differing

BLOCK: Final = 5
"""Seeds that `Context.run_until_certain` walks between two looks."""

Plates: TypeAlias = tuple[tuple[float, PlateUnderFoot], ...]
"""Plates by time of the walk, s."""


@dataclass(frozen=True)
class Context:
    """Everything an experiment depends on beside its own numbers."""

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

    def first(self, n: int) -> Context:
        """The same with the first few seeds only."""
        return replace(self, seeds=self.seeds[:n])

    def on(self, wear: str) -> Context:
        """The same on a robot in another state of wear."""
        return replace(self, changes=msgspec.structs.replace(self.changes, wear=wear))

    def on_engine(self, engine: str) -> Context:
        """The same on a physics engine."""
        return replace(self, changes=msgspec.structs.replace(self.changes, engine=engine))

    def config(self, gait: str, seed: int, switches: dict[str, Any]) -> RunConfig:
        """The configuration of a run.

        Args:
            gait: Name.
            seed: Of the run.
            switches: Fields of `walker.switches.Switches`: what the arms of an experiment differ
                in. They overrule the changes, which hold for their own gait.
        """
        same = gait == self.changes.gait
        return RunConfig(
            robot=self.robot,
            wear=wear_of_seed(self.wear, seed),
            engine=self.engine,
            gait=gait,
            seed=seed,
            steps=0,
            parameters=self.changes.parameters if same else {},
            controller=merged(
                self.changes.controller if same else {}, {"switches": switches} if switches else {}
            ),
        )

    def walks(
        self,
        name: str,
        gait: str,
        duration: float,
        switches: dict[str, Any] | None = None,
        *,
        velocity: tuple[float, ...] = (),
        plates: Callable[[int], Plates] | None = None,
        **fields: Any,
    ) -> list[Walk]:
        """One walk per seed.

        Args:
            name: Of the arm.
            gait: Name.
            duration: Of the walk, s.
            switches: As in `config`.
            velocity: m/s, m/s, rad/s; empty: the gait's own.
            plates: By seed, with their times of the walk.
            fields: More of `Walk`.
        """
        return [
            Walk(
                name=name,
                config=msgspec.structs.replace(self.config(gait, seed, switches or {}), velocity=velocity),
                duration=duration,
                world_events=plates(seed) if plates else (),
                **fields,
            )
            for seed in self.seeds
        ]

    def run_switches(
        self,
        name: str,
        gait: str,
        duration: float,
        arms: Mapping[str, dict[str, Any]],
        plates: Callable[[int], Plates] | None = None,
    ) -> list[list[WalkOutcome]]:
        """As `run`, with arms that differ in switches alone.

        Args:
            name: Of the experiment.
            gait: Name.
            duration: Of each walk, s.
            arms: Switches by the arm's name.
            plates: As in `walks`.
        """
        walks = (self.walks(f"{name}, {arm}", gait, duration, on, plates=plates) for arm, on in arms.items())
        return self.run(*walks)

    def run(self, *arms: Sequence[Walk]) -> list[list[WalkOutcome]]:
        """Walk several arms in one go, seed by seed, so that a stop leaves about as many of each.

        Each arm differs in one switch at most from the one before it, or in the gait with all that is the
        gait's own: what differs is what the arms show.

        Raises:
            Interrupted: it was stopped before each arm had a run.
            ValueError: two neighbouring arms differ in more than that.
            NaoHilError: a configuration that cannot be walked, or a run that failed.
        """
        for one, other in pairwise(arms):
            _check_one_difference(one[0], other[0])
        mixed = [walk for of_seed in zip_longest(*arms) for walk in of_seed if walk]
        done = {(result.walk.name, result.seed): result for result in self.campaign.walk(mixed)}
        results = [[done[k] for w in arm if (k := (w.name, w.config.seed)) in done] for arm in arms]
        if not all(results):
            raise Interrupted
        return results

    def run_until_certain(self, share: float, *arms: Sequence[Walk]) -> list[list[WalkOutcome]]:
        """As `run`, a block of seeds at a time; an arm ends when further seeds cannot change its verdict.

        The verdict is whether the lower bound of Wilson's interval of the share that stands, with all seeds
        walked, is `share` or more. Ending early changes no verdict (curtailed sampling). With so few seeds that
        not even all of them could reach it, all are walked.

        Args:
            share: 0..1.
            arms: As in `run`, all with the same seeds.
        """
        if wilson(len(self.seeds), len(self.seeds))[0] < share:
            return self.run(*arms)
        results: list[list[WalkOutcome]] = [[] for _ in arms]
        for begin in range(0, len(self.seeds), BLOCK):
            open_ = [k for k, found in enumerate(results) if not _certain(found, len(self.seeds), share)]
            if not open_:
                break
            for k, found in zip(open_, self.run(*(arms[k][begin : begin + BLOCK] for k in open_)), strict=True):
                results[k] += found
        return results


def _certain(found: Sequence[WalkOutcome], seeds: int, share: float) -> bool:
    """Whether the verdict is the same if all other seeds stand and if all others fall."""
    stood = sum(result.end.survived for result in found)
    return wilson(stood + seeds - len(found), seeds)[0] < share or wilson(stood, seeds)[0] >= share


def _check_one_difference(one: Walk, other: Walk) -> None:
    if one.config.gait != other.config.gait:
        if one.config.controller != other.config.controller:
            raise ValueError(f"arms {one.name} and {other.name} differ in the gait and in the controller")
        return
    switches = (controller_parameters(w.config.gait, w.config.controller).switches for w in (one, other))
    if len(names := differing(*switches)) > 1:
        raise ValueError(
            f"arms {one.name} and {other.name} differ in {len(names)} switches: {', '.join(names)}"
        )
