"""Push map: the impulse at the torso at which half fall, by its direction and by the phase of the stride."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from nao_hil.analysis.report.render import Claim, Columns, ReportTable, table
from nao_hil.analysis.statistics import Estimate
from nao_hil.experiments import axes
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Drawing, Experiment, Measured, bounded
from nao_hil.runs.events import StridePush

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


class Place(NamedTuple):
    """A direction and a phase."""

    direction: float
    """In which it pushes, rad: 0 forward, pi/2 to the left."""
    phase: float | None
    """Part of the stride since the left single support; None: of a standing robot."""

    def words(self) -> str:
        """As text for the report."""
        when = "standing" if self.phase is None else f"phase {self.phase:g}"
        return f"{math.degrees(self.direction):g} deg, {when}"


class PushCell(msgspec.Struct, frozen=True, kw_only=True):
    """Threshold of a place."""

    direction: float
    phase: float | None
    impulse: Estimate
    """At which half fall, N s."""
    n: int


def _measure(context: Context) -> dict[Place, ThresholdSearch]:
    """Search all cells at once: one walk of each per seed, at the impulse that its walks before point to."""
    turn = [math.tau * i / DIRECTIONS for i in range(DIRECTIONS)]
    places = [Place(d, i / PHASES) for d in turn for i in range(PHASES)] + [Place(d, None) for d in turn]
    searches = {place: ThresholdSearch(*RANGE) for place in places}
    for seed in context.seeds:
        one = replace(context, seeds=(seed,))
        strengths = {place: search.threshold.value for place, search in searches.items()}
        walks = {place: _task(_gait(context), place, strength) for place, strength in strengths.items()}
        named = {place: task.walks(one, f"push map, {place.words()}") for place, task in walks.items()}
        results = {r.walk.name: r for r in one.walk_all([walk for (walk,) in named.values()])}
        for place, (walk,) in named.items():
            searches[place].add_trial(strengths[place], not results[walk.name].end.survived)
    return searches


def _gait(context: Context) -> str:
    return context.gait or "omni"


def _task(gait: str, place: Place, impulse: float) -> Task:
    push = StridePush(
        time=BEFORE, phase=place.phase, impulse=impulse, direction=place.direction, duration=LENGTH
    )
    fields = {"pushes": (push,), "stand": place.phase is None, "keep_track": False}
    return Task(gait, BEFORE + AFTER, {"velocity": (SPEED, 0.0, 0.0)}, fields=fields)


def _quantities(measured: Measured[dict[Place, ThresholdSearch]]) -> dict[str, Any]:
    cells = [
        PushCell(direction=place.direction, phase=place.phase, impulse=search.threshold, n=len(search.trials))
        for place, search in measured.results.items()
    ]
    worst, best, still = _decisive(cells)
    return {
        "gait": _gait(measured.context),
        "walking_worst_ns": worst.impulse.value,
        "walking_best_ns": best.impulse.value,
        "standing_worst_ns": still.impulse.value,
        "cells": cells,
    }


def _decisive(cells: Sequence[PushCell]) -> tuple[PushCell, PushCell, PushCell]:
    """Worst and best cell of a walk, and the worst of a stand."""
    walking = [each for each in cells if each.phase is not None]
    standing = [each for each in cells if each.phase is None]
    strength = attrgetter("impulse.value")
    return min(walking, key=strength), max(walking, key=strength), min(standing, key=strength)


def _claims(measured: Measured[dict[Place, ThresholdSearch]]) -> list[Claim]:
    claims = (
        ("Walking, the worst cell", WALKING_WORST),
        ("Walking, the best cell", WALKING_BEST),
        ("Standing, the worst direction", STANDING_WORST),
    )
    return [
        bounded(
            f"{cell} bears {least:g} N s",
            found.impulse,
            least,
            words="{0.value:.2f} N s ({0.interval[0]:.2f} to {0.interval[1]:.2f}), "
            + Place(found.direction, found.phase).words(),
        )
        for (cell, least), found in zip(claims, _decisive(measured.figures["cells"]), strict=True)
    ]


def _table(measured: Measured[dict[Place, ThresholdSearch]]) -> list[ReportTable]:
    columns: Columns = {
        "direction, deg": lambda each: f"{math.degrees(each.direction):g}",
        "phase of the stride": lambda each: "stands" if each.phase is None else f"{each.phase:g}",
        "N s": "{0.impulse.value:.2f}",
        "95 % interval": "{0.impulse.interval[0]:.2f} to {0.impulse.interval[1]:.2f}",
        "walks": "{0.n}",
    }
    return [table("Impulse at which half fall", measured.figures["cells"], columns)]


def _draw(figure: Figure, measured: Measured[dict[Place, ThresholdSearch]]) -> None:
    left: Any = figure.add_subplot(1, 2, 1)
    right: Any = figure.add_subplot(1, 2, 2, projection="polar")
    impulse = {(each.direction, each.phase): each.impulse for each in measured.figures["cells"]}
    directions = sorted({direction for direction, _ in impulse})
    phases = sorted({phase for _, phase in impulse if phase is not None})
    shares = np.array([[impulse[direction, phase].value for phase in phases] for direction in directions])
    image = left.imshow(shares, origin="lower", aspect="auto", cmap="viridis", vmin=0.0)
    for (row, column), value in np.ndenumerate(shares):
        colour = "k" if value > 0.6 * shares.max() else "w"
        left.text(column, row, f"{value:.1f}", ha="center", va="center", color=colour, fontsize=8)
    left.set_xticks(range(len(phases)), [f"{phase:g}" for phase in phases])
    left.set_yticks(range(len(directions)), [f"{math.degrees(d):.0f}" for d in directions])
    left.set(xlabel="phase of the stride (0: left foot stands, 0.5: right)", ylabel="pushed to / deg, 90: left")
    figure.colorbar(image, ax=left, label="N s")
    around = [*directions, directions[0] + math.tau]
    low, middle, high = (np.append(of, of[0]) for of in (shares.min(1), np.median(shares, 1), shares.max(1)))
    right.fill_between(around, low, high, alpha=0.25, color=axes.BLUE)
    right.plot(around, middle, color=axes.BLUE, label="walking")
    still = [impulse[direction % math.tau, None] for direction in around]
    value = np.array([each.value for each in still])
    off = np.abs(np.array([each.interval for each in still]) - value[:, None]).T
    right.errorbar(around, value, off, color=axes.RED, capsize=3, label="standing")
    right.set_theta_zero_location("N")
    right.set_ylim(0.0)
    right.legend(fontsize=8, loc="lower left", bbox_to_anchor=(-0.15, -0.1))


PUSH_MAP: Final = Experiment(
    title=lambda measured: f"Pushes at the torso by direction and phase, the gait {_gait(measured.context)}",
    source="Larger robots scaled to a NAO bear 0.33 to 0.84 N s.",
    setup=(
        ("walk", f"{SPEED:g} m/s; the push is in the first stride after {BEFORE:g} s"),
        ("push", f"{LENGTH:g} s long, constant, at the torso's centre of mass"),
        ("stands", f"{AFTER:g} s after {BEFORE:g} s"),
        (
            "search",
            "Bayesian, each walk at the median so far; 95 % credible intervals; a walk of each cell per seed",
        ),
    ),
    measure=_measure,
    quantities=_quantities,
    claims=_claims,
    tables=_table,
    pictures=(
        Drawing(
            "push-map.png",
            _draw,
            "Impulse at which half fall, N s",
            "Left: by direction of the push and phase of the stride. Right: by direction; walking the median "
            "and the range over the phases, standing with its intervals.",
            (11.0, 5.0),
        ),
    ),
)
