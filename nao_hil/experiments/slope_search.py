"""Search for the steepest slope that a gait walks, by trials of a few seeds."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from typing import Final

import msgspec

from nao_hil.analysis.statistics import wilson
from nao_hil.runs.walk import WalkOutcome

STEP: Final = 0.5
"""Degrees"""


@dataclass(frozen=True)
class SlopeSetup:
    """The experiment's numbers; slopes in degrees, because they are typed and read."""

    duration: float = 30.0
    """s"""
    goal: float = 5.0
    steepest: float = 10.0
    """Where the search ends."""
    share: float = 0.8
    """That must walk on: by the ratio in the search, by the lower bound of the interval in the end."""
    few: int = 10
    """Most seeds of a trial in the search."""
    batch: int = 2
    """Seeds per direction that are walked at a time."""


class Slope(msgspec.Struct, frozen=True, kw_only=True):
    """The steepest slope of one direction at which enough walk on."""

    slope_deg: float
    n: int
    survived: int
    interval: tuple[float, float]


Request = tuple[float, tuple[int, ...]]
"""A slope in degrees and the seeds to try it with."""


Search = Generator[Request, Sequence[bool], float]


@dataclass
class Tally:
    """What is known of one direction."""

    runs: dict[float, dict[int, WalkOutcome]] = field(default_factory=dict)
    """By slope and seed."""

    def count(self, slope: float) -> tuple[int, int]:
        """Survived and tried at a slope."""
        tried = self.runs.get(slope, {})
        return sum(result.end.survived for result in tried.values()), len(tried)


def enough(n: int, share: float) -> int:
    """Least number of `n` of which the lower bound of Wilson's interval is `share`; n where none is."""
    return next((k for k in range(n) if wilson(k, n)[0] >= share), n)


def trial(
    slope: float, seeds: Sequence[int], needed: int, batch: int
) -> Generator[Request, Sequence[bool], bool]:
    """Try a slope seed by seed until it is sure whether `needed` of all these seeds walk on.

    Yields what to try next, is sent who survived, and returns the verdict.
    """
    survived = fallen = 0
    while survived < needed and fallen <= len(seeds) - needed:
        begin = survived + fallen
        alive = yield slope, tuple(seeds[begin : begin + batch])
        survived += sum(alive)
        fallen += len(alive) - sum(alive)
    return survived >= needed


def search(seeds: Sequence[int], setup: SlopeSetup) -> Search:
    """The steepest slope, degrees: bisection on half degrees from the goal on, confirmed with all seeds."""
    few = seeds[: setup.few]
    most_of_few = math.ceil(setup.share * len(few) - 1e-9)
    low, high = 0, round(setup.steepest / STEP) + 1
    middle = round(setup.goal / STEP)
    while high - low > 1:
        if (yield from trial(middle * STEP, few, most_of_few, setup.batch)):
            low = middle
        else:
            high = middle
        middle = (low + high) // 2
    all_that_count = enough(len(seeds), setup.share)
    while not (yield from trial(low * STEP, seeds, all_that_count, setup.batch)) and low > 0:
        low -= 1
    return low * STEP
