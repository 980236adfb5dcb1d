"""Walks and campaigns that are made up, for tests of those who judge them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from nao_hil.experiments.context import Context
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from nao_hil.runs.track import WIDTH, Track
from nao_hil.runs.walk import Ending, Walk, WalkEnd, WalkOutcome

NO_TRACK = Track(np.zeros((0, WIDTH), dtype=np.float32))


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
