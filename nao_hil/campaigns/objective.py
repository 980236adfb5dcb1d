"""Objective of a study: the lower bound of the mean score of an ensemble of walks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Final

import msgspec

from emulator.scenarios import load_scenario
from nao_hil.analysis.statistics import score_bounds
from nao_hil.campaigns.file import with_seed
from nao_hil.campaigns.quantities import changed_all
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk, WalkEnd

MAX_SCORED_TILT: Final = math.radians(30.0)
"""Largest tilt that still scores."""
BATCH_SIZE: Final = 4
"""Walks between two decisions on stopping."""


def score(end: WalkEnd, duration: float) -> float:
    """0 to 1. A fall scores up to a half, by the time upright; a complete walk more, by its uprightness."""
    if not end.survived:
        return 0.5 * min(1.0, end.time / duration)
    return 1.0 - 0.5 * min(1.0, end.tilt_max / MAX_SCORED_TILT)


class Ensemble(msgspec.Struct, frozen=True, kw_only=True):
    """Robots, worlds and seeds that a set of parameters must walk."""

    base: RunConfig
    robots: tuple[str, ...]
    wears: tuple[str, ...]
    scenarios: tuple[str, ...]
    first_seed: int
    seeds: int
    duration: float

    def walks(self, point: dict[str, float], first_seed: int | None = None) -> list[Walk]:
        """All walks of a point, seed by seed.

        Args:
            point: Values by quantity.
            first_seed: In place of the ensemble's.

        Raises:
            ConfigurationError: an unknown quantity or an impossible value.
        """
        first = self.first_seed if first_seed is None else first_seed
        tasks = []
        for robot, wear, scenario in itertools.product(self.robots, self.wears, self.scenarios):
            config = msgspec.structs.replace(self.base, robot=robot, wear=wear, scenario=scenario)
            task = Walk(
                name=f"{robot}, {wear}, {scenario}",
                config=config,
                duration=self.duration,
                scenario=load_scenario(scenario),
                keep_track=False,
            )
            tasks.append(changed_all(task, point))
        return [with_seed(task, first + k) for k in range(self.seeds) for task in tasks]


def judge(
    walks: Sequence[Walk],
    attempt: Callable[[Sequence[Walk]], Sequence[WalkEnd]],
    go_on: Callable[[int, float, tuple[float, float]], bool],
) -> tuple[int, float]:
    """Walk batch by batch until all are walked or it is not worth it.

    Args:
        walks: Of one point.
        attempt: Walks some of them.
        go_on: Called with the number of walks so far, the sum of their scores, and the bounds of their mean.

    Returns:
        Number of walks, and the sum of their scores.
    """
    n, total = 0, 0.0
    for begin in range(0, len(walks), BATCH_SIZE):
        batch = walks[begin : begin + BATCH_SIZE]
        total += sum(score(end, walks[0].duration) for end in attempt(batch))
        n += len(batch)
        if n < len(walks) and not go_on(n, total, score_bounds(total, n)):
            break
    return n, total
