"""Push map: the impulse at the torso at which half fall, by its direction and by the phase of the stride."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from operator import attrgetter
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
from scipy.stats import norm

from nao_hil.analysis.report.render import Claim, Outcome, Picture, ReportTable
from nao_hil.analysis.statistics import Estimate, few_words
from nao_hil.experiments import axes
from nao_hil.experiments.context import Context
from nao_hil.files import save_figure
from nao_hil.runs.events import StridePush
from nao_hil.runs.walk import Walk

LAPSE: Final = 0.02
"""Chance that the strength does not matter in a trial."""
_SPREADS: Final = np.array([0.05, 0.1, 0.2, 0.4])
"""w, each as likely as the others before the trials."""


class ThresholdSearch:
    """The strength of a stimulus at which half of the trials fail, by few trials.

    Bayesian adaptive estimation on a grid (Watson and Pelli, QUEST, Perception & Psychophysics 33, 1983), with
    the slope as a second unknown. The chance of a failure at the strength s is Phi(ln(s / m) / w), mixed with a
    chance for trials that fail or stand at any strength. All strengths are equally likely at first, by their
    logarithm.

    Args:
        low: Smallest strength.
        high: Largest one.
    """

    def __init__(self, low: float, high: float) -> None:
        self._strengths = np.geomspace(low, high, 121)
        self._weights = np.ones((len(self._strengths), len(_SPREADS)))
        self.trials: list[tuple[float, bool]] = []
        """Strength, and whether it failed."""

    def add_trial(self, strength: float, failed: bool) -> None:
        """One trial."""
        distance = np.log(strength / self._strengths)[:, None] / _SPREADS
        chance = 0.5 * LAPSE + (1.0 - LAPSE) * norm.cdf(distance)
        self._weights = self._weights * (chance if failed else 1.0 - chance)
        self._weights /= self._weights.sum()
        self.trials.append((strength, failed))

    @property
    def threshold(self) -> Estimate:
        """Median and 95 % credible interval of its distribution."""
        total = np.cumsum(self._weights.sum(axis=1))
        low, middle, high = np.interp((0.025, 0.5, 0.975), total / total[-1], self._strengths).tolist()
        return Estimate(value=middle, interval=(low, high))


SPEED: Final = 0.15
"""m/s of the walks."""
DIRECTIONS: Final = 8
PHASES: Final = 8
BEFORE: Final = 2.0
"""s of the walk from which on a stride is waited for."""
AFTER: Final = 6.0
"""s from then on to the end of the walk; the robot must stand then. After a step out of a stand the feet close
within 4 s."""
LENGTH: Final = 0.1
"""s of a push."""
RANGE: Final = (0.2, 8.0)
"""Impulses that are searched, N s."""
WALKING_WORST: Final = 1.5
"""N s that the worst cell of a walk is to bear, and so on."""
WALKING_BEST: Final = 3.0
STANDING_WORST: Final = 3.0


class PushCell(msgspec.Struct, frozen=True, kw_only=True):
    """A direction and a phase."""

    direction: float
    """In which it pushes, rad: 0 forward, pi/2 to the left."""
    phase: float | None
    """Part of the stride since the left single support; None: of a standing robot."""
    impulse: Estimate
    """At which half fall, N s."""
    n: int


_Place = tuple[float, float | None]
"""Direction, and phase or None."""


def experiment(context: Context) -> Outcome:
    """Search all cells at once: one walk of each per seed, at the impulse that its walks before point to."""
    gait = context.gait or "omni"
    turn = [math.tau * i / DIRECTIONS for i in range(DIRECTIONS)]
    phases = [i / PHASES for i in range(PHASES)]
    places: list[_Place] = [(d, p) for d in turn for p in phases] + [(d, None) for d in turn]
    searches = {place: ThresholdSearch(*RANGE) for place in places}
    for seed in context.seeds:
        _round(replace(context, seeds=(seed,)), gait, searches)
    cells = [
        PushCell(direction=place[0], phase=place[1], impulse=search.threshold, n=len(search.trials))
        for place, search in searches.items()
    ]
    walking = [each for each in cells if each.phase is not None]
    standing = [each for each in cells if each.phase is None]
    strength = attrgetter("impulse.value")
    worst, best = min(walking, key=strength), max(walking, key=strength)
    still, n = min(standing, key=strength), len(context.seeds)
    return context.outcome(
        "push-map",
        f"Pushes at the torso by direction and phase, the gait {gait}, {n} walks a cell{few_words(n)}",
        "Larger robots scaled to a NAO bear 0.33 to 0.84 N s.",
        setup=[
            ("walk", f"{SPEED:g} m/s; the push is in the first stride after {BEFORE:g} s"),
            ("push", f"{LENGTH:g} s long, constant, at the torso's centre of mass"),
            ("stands", f"{AFTER:g} s after {BEFORE:g} s"),
            ("search", "Bayesian, each walk at the median so far; 95 % credible intervals"),
        ],
        claims=[
            _claim("Walking, the worst cell", worst, WALKING_WORST),
            _claim("Walking, the best cell", best, WALKING_BEST),
            _claim("Standing, the worst direction", still, STANDING_WORST),
        ],
        pictures=[
            Picture(
                _plot(context.out / "push-map.png", walking, standing),
                "Impulse at which half fall, N s",
                "Left: by direction of the push and phase of the stride. Right: by direction; walking the "
                "median and the range over the phases, standing with its intervals.",
            )
        ],
        tables=[_table(cells)],
        figures={
            "gait": gait,
            "walking_worst_ns": worst.impulse.value,
            "walking_best_ns": best.impulse.value,
            "standing_worst_ns": still.impulse.value,
            "cells": cells,
        },
    )


def _round(context: Context, gait: str, searches: dict[_Place, ThresholdSearch]) -> None:
    """One walk of each cell."""
    strengths = {place: search.threshold.value for place, search in searches.items()}
    walks = [_walk(context, gait, place, strength) for place, strength in strengths.items()]
    results = {result.walk.name: result for result in context.walk_all(walks)}
    for walk, (place, search) in zip(walks, searches.items(), strict=True):
        search.add_trial(strengths[place], not results[walk.name].end.survived)


def _walk(context: Context, gait: str, place: _Place, impulse: float) -> Walk:
    direction, phase = place
    push = StridePush(time=BEFORE, phase=phase, impulse=impulse, direction=direction, duration=LENGTH)
    (walk,) = context.walks(
        f"push map, {_words(place)}",
        gait,
        BEFORE + AFTER,
        velocity=(SPEED, 0.0, 0.0),
        pushes=(push,),
        stand=phase is None,
        keep_track=False,
    )
    return walk


def _claim(what: str, found: PushCell, least: float) -> Claim:
    low, high = found.impulse.interval
    where = _words((found.direction, found.phase))
    return Claim(
        f"{what} bears {least:g} N s",
        f"{found.impulse.value:.2f} N s ({low:.2f} to {high:.2f}), {where}",
        low >= least,
    )


def _words(place: _Place) -> str:
    direction, phase = place
    when = "standing" if phase is None else f"phase {phase:g}"
    return f"{math.degrees(direction):g} deg, {when}"


def _table(cells: Sequence[PushCell]) -> ReportTable:
    rows = tuple(
        (
            f"{math.degrees(each.direction):g}",
            "stands" if each.phase is None else f"{each.phase:g}",
            f"{each.impulse.value:.2f}",
            "{:.2f} to {:.2f}".format(*each.impulse.interval),
            f"{each.n}",
        )
        for each in cells
    )
    head = ("direction, deg", "phase of the stride", "N s", "95 % interval", "walks")
    return ReportTable("Impulse at which half fall", head, rows)


def _plot(path: Path, walking: Sequence[PushCell], standing: Sequence[PushCell]) -> Path:
    figure = axes.new_figure(11.0, 5.0)
    left: Any = figure.add_subplot(1, 2, 1)
    right: Any = figure.add_subplot(1, 2, 2, projection="polar")
    directions = sorted({each.direction for each in walking})
    phases = sorted({each.phase for each in walking if each.phase is not None})
    values = {(each.direction, each.phase): each.impulse.value for each in walking}
    table = np.array([[values[direction, phase] for phase in phases] for direction in directions])
    image = left.imshow(table, origin="lower", aspect="auto", cmap="viridis", vmin=0.0)
    for (row, column), value in np.ndenumerate(table):
        colour = "k" if value > 0.6 * table.max() else "w"
        left.text(column, row, f"{value:.1f}", ha="center", va="center", color=colour, fontsize=8)
    left.set_xticks(range(len(phases)), [f"{phase:g}" for phase in phases])
    left.set_yticks(range(len(directions)), [f"{math.degrees(d):.0f}" for d in directions])
    left.set(xlabel="phase of the stride (0: left foot stands, 0.5: right)", ylabel="pushed to / deg, 90: left")
    figure.colorbar(image, ax=left, label="N s")
    around = [*directions, directions[0] + math.tau]
    low, middle, high = (
        np.append(each, each[0]) for each in (table.min(axis=1), np.median(table, axis=1), table.max(axis=1))
    )
    right.fill_between(around, low, high, alpha=0.25, color=axes.BLUE)
    right.plot(around, middle, color=axes.BLUE, label="walking")
    still = {each.direction: each.impulse for each in standing}
    value = np.array([still[direction % math.tau].value for direction in around])
    bounds = np.array([still[direction % math.tau].interval for direction in around])
    right.errorbar(
        around, value, np.abs(bounds - value[:, None]).T, color=axes.RED, capsize=3, label="standing"
    )
    right.set_theta_zero_location("N")
    right.set_ylim(0.0)
    right.legend(fontsize=8, loc="lower left", bbox_to_anchor=(-0.15, -0.1))
    return save_figure(figure, path)
