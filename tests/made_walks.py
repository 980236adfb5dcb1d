"""Walks and campaigns that are made up, for tests of those who judge them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from nao_hil.experiments.context import Context
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from nao_hil.runs.run import Table
from nao_hil.runs.walk import NO_TRACK, Ending, Walk, WalkEnd, WalkOutcome


def made_track(columns: Mapping[str, Any]) -> Table:
    """The track of a made walk: some of its columns, the others zero, and an upright torso."""
    n = max(len(value) for value in columns.values())
    zeros: dict[str, Any] = {name: np.zeros((n, *NO_TRACK[name].shape[1:])) for name in NO_TRACK}
    zeros["world/truth.torso_orientation"][:, 3] = 1.0
    return Table(zeros | {name: np.asarray(value) for name, value in columns.items()}, NO_TRACK.columns)


def walk_end(ending: Ending = "walked", time: float = 60.0, **fields: Any) -> WalkEnd:
    """An end without motion but for the fields that are given."""
    rest: dict[str, Any] = {"roll": 0.0, "pitch": 0.0, "steps": 1, "distance": 0.0, "tilt_max": 0.05} | fields
    return WalkEnd(ending=ending, time=time, **rest)


class MadeCampaign:
    """A campaign whose walks end as a function says, and which is stopped after some.

    Args:
        end: Of a walk.
        most: Walks that are walked.
    """

    def __init__(self, end: Callable[[Walk], WalkEnd] = lambda _: walk_end(), most: int | None = None) -> None:
        self._end, self._most = end, most
        self.asked: list[Walk] = []

    def walk(self, walks: Sequence[Walk]) -> list[WalkOutcome]:
        self.asked += walks
        return [WalkOutcome(task, self._end(task), NO_TRACK) for task in walks[: self._most]]


def made_context(
    campaign: MadeCampaign, out: Path, seeds: Sequence[int], changes: RunConfig | None = None, **fields: Any
) -> Context:
    """A context that runs in a made campaign; of a nominal robot, if no changes are given."""
    return Context(cast(Campaign, campaign), out, tuple(seeds), changes or RunConfig(wear="nominal"), **fields)
