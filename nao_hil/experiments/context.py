"""What every experiment is given: robot, wear, seeds, changed parameters, a campaign, and a folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import msgspec

from bridge.messages.world import PlateUnderFoot
from emulator.scenarios import Scenario
from nao_hil.runs.campaign import Campaign, Interrupted
from nao_hil.runs.config import Engine, RunConfig
from nao_hil.runs.walk import Walk, WalkOutcome

ENOUGH: Final = 20
"""Seeds for a comparison, unless told otherwise."""


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

    @property
    def robot(self) -> str:
        """Name or path of the body."""
        return self.changes.robot

    @property
    def wear(self) -> str:
        """Name or path of the wear profile."""
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

    def config(self, gait: str, seed: int, switches: dict[str, Any]) -> RunConfig:
        """The configuration of a run.

        Args:
            gait: Name.
            seed: Of the run.
            switches: Of the controller, `torso` and `admittance`: what the arms of an experiment differ in.
                They overrule the changes, which hold for their own gait.
        """
        same = gait == self.changes.gait
        return RunConfig(
            robot=self.robot,
            wear=self.wear,
            engine=self.engine,
            gait=gait,
            seed=seed,
            steps=0,
            parameters=self.changes.parameters if same else {},
            controller=(self.changes.controller if same else {}) | switches,
        )

    def walks(
        self,
        name: str,
        gait: str,
        duration: float,
        switches: dict[str, Any] | None = None,
        *,
        scenario: Scenario | None = None,
        plates: tuple[tuple[float, PlateUnderFoot], ...] = (),
        keep_track: bool = True,
    ) -> list[Walk]:
        """One walk per seed; arguments as in `Walk` and `config`."""
        return [
            Walk(
                name=name,
                config=self.config(gait, seed, switches or {}),
                duration=duration,
                scenario=scenario or Scenario(),
                plates=plates,
                keep_track=keep_track,
            )
            for seed in self.seeds
        ]

    def run(self, *arms: Sequence[Walk]) -> list[list[WalkOutcome]]:
        """Walk several arms in one go, seed by seed, so that a stop leaves about as many of each.

        Raises:
            Interrupted: it was stopped before each arm had a run.
            NaoHilError: a configuration that cannot be walked, or a run that failed.
        """
        mixed = [walk for seed in zip(*arms, strict=True) for walk in seed]
        done = {(result.walk.name, result.seed): result for result in self.campaign.walk(mixed)}
        results = [[done[k] for w in arm if (k := (w.name, w.config.seed)) in done] for arm in arms]
        if not all(results):
            raise Interrupted
        return results
