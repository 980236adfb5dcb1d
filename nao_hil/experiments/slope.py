"""R6: the steepest slope in each of four directions that the robot walks on, not knowing of it (4.2.3, ch. 5).

Swept in half degrees by bisection. Each slope is tried with a few seeds, in order, until its verdict is
sure; the steepest that passes is then confirmed with all seeds, and half a degree less taken if it fails.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeAlias

import numpy as np
from matplotlib.figure import Figure

from nao_hil.analysis.report.render import Claim, Columns, ReportTable, table
from nao_hil.analysis.statistics import Share, percent, wilson
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import falls_finding
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Drawing, Experiment, Measured
from nao_hil.runs.walk import Walk, WalkOutcome

STEP: Final = 0.5
"""Degrees"""
GAIT: Final = "static"
"""Gait of the thesis; another one with `--gait`."""
DIRECTIONS: Final[dict[str, tuple[float, float]]] = {
    "up": (0.0, -1.0),
    "down": (0.0, 1.0),
    "left": (1.0, 0.0),
    "right": (-1.0, 0.0),
}
"""Roll and pitch of the floor per degree of slope. `left`: across the slope, the left side higher."""


@dataclass(frozen=True)
class SlopeSetup:
    """The experiment's numbers; slopes in degrees, because they are typed and read."""

    duration: float = 30.0
    """Duration of a trial, s."""
    goal: float = 5.0
    steepest: float = 10.0
    """Where the search ends."""
    share: float = 0.8
    """That must walk on: by the ratio in the search, by the lower bound of the interval in the end."""
    few: int = 10
    """Most seeds of a trial in the search."""
    batch: int = 2
    """Seeds per direction that are walked at a time."""


DEFAULT: Final = SlopeSetup()


class Slope(Share, frozen=True, kw_only=True):
    """The steepest slope of one direction at which enough walk on."""

    slope_deg: float


Search: TypeAlias = Generator[tuple[float, tuple[int, ...]], Sequence[bool], float]
"""Asks for a slope in degrees and the seeds to try it with."""


@dataclass
class Tally:
    """Trials of one direction."""

    runs: dict[float, dict[int, WalkOutcome]] = field(default_factory=dict)
    """By slope and seed."""
    steepest: float = 0.0
    """Steepest slope that passes, degrees."""

    def share(self, slope: float) -> Share:
        """Trials at a slope that walked on."""
        tried = self.runs.get(slope, {})
        return Share(n=len(tried), survived=sum(result.end.survived for result in tried.values()))


def enough(n: int, share: float) -> int:
    """Least number of `n` of which the lower bound of Wilson's interval is `share`; n where none is."""
    return next((k for k in range(n) if wilson(k, n)[0] >= share), n)


def trial(
    slope: float, seeds: Sequence[int], needed: int, batch: int
) -> Generator[tuple[float, tuple[int, ...]], Sequence[bool], bool]:
    """Try a slope seed by seed until it is sure whether `needed` of all these seeds walk on.

    Yields the next trial, is sent its survivors, and returns the verdict.
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


def sweep(context: Context, setup: SlopeSetup = DEFAULT) -> dict[str, Tally]:
    """Advance the searches of all directions together: each round is one batch for the workers."""
    searches = {name: search(context.seeds, setup) for name in DIRECTIONS}
    tallies = {name: Tally() for name in DIRECTIONS}
    wanted = {name: next(steps) for name, steps in searches.items()}
    while wanted:
        walks = [
            walk
            for name, (slope, seeds) in wanted.items()
            for walk in _walks(replace(context, seeds=seeds), setup, name, slope)
        ]
        results = {(r.walk.name, r.seed): r for r in context.walk_all(walks)}
        for name, (slope, seeds) in list(wanted.items()):
            runs = {seed: results[_name(name, slope), seed] for seed in seeds}
            tallies[name].runs.setdefault(slope, {}).update(runs)
            try:
                wanted[name] = searches[name].send([runs[seed].end.survived for seed in seeds])
            except StopIteration as stop:
                tallies[name].steepest = stop.value
                del wanted[name]
    return tallies


def _walks(context: Context, setup: SlopeSetup, name: str, slope: float) -> list[Walk]:
    roll, pitch = (slope * part for part in DIRECTIONS[name])
    floor = {"scenario.floor.roll": roll, "scenario.floor.pitch": pitch}
    task = Task(context.gait or GAIT, setup.duration, floor, fields={"keep_track": False})
    return task.walks(context, _name(name, slope))


def _name(direction: str, slope: float) -> str:
    return f"slope, {direction}, {slope:g} deg"


def _words(name: str) -> str:
    return {"up": "Uphill", "down": "Downhill"}.get(name, f"Across, the {name} side higher")


def _quantities(measured: Measured[dict[str, Tally]]) -> dict[str, Any]:
    slopes = {}
    for name, tally in measured.results.items():
        share = tally.share(tally.steepest)
        slopes[name] = Slope(slope_deg=tally.steepest, n=share.n, survived=share.survived)
    return slopes


def _claims(measured: Measured[dict[str, Tally]]) -> list[Claim]:
    goal, share = DEFAULT.goal, DEFAULT.share
    return [
        Claim(
            f"{_words(name)}: {goal:g} degrees or more at {100 * share:.0f} %",
            f"{found.slope_deg:g} deg ({found.words()})",
            found.slope_deg >= goal and found.interval[0] >= share,
        )
        for name, found in measured.figures.items()
    ]


def _findings(measured: Measured[dict[str, Tally]]) -> list[str]:
    """Falls on the next steeper slope of each search."""
    return [
        falls_finding(f"{_words(name)} at {slope:g} deg", list(tally.runs[slope].values()), None)
        for name, tally in measured.results.items()
        for slope in sorted(slope for slope in tally.runs if slope > tally.steepest)[:1]
    ]


def _table(measured: Measured[dict[str, Tally]]) -> list[ReportTable]:
    tried = [
        (_words(name), slope, tally.share(slope))
        for name, tally in measured.results.items()
        for slope in sorted(tally.runs)
    ]
    columns: Columns = {
        "direction": "{0[0]}",
        "slope, deg": "{0[1]:g}",
        "walk on": "{0[2].survived} of {0[2].n}",
        "95 % interval": lambda item: percent(item[2].interval),
    }
    return [table("Slopes tried", tried, columns)]


def _draw(figure: Figure, measured: Measured[dict[str, Tally]]) -> None:
    panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel().tolist()
    for panel, (name, tally) in zip(panels, measured.results.items(), strict=True):
        slopes = sorted(tally.runs)
        shares = [tally.share(slope) for slope in slopes]
        ratios = np.array([share.survival_ratio for share in shares])
        off = np.abs(np.array([share.interval for share in shares]).T - ratios)
        panel.errorbar(slopes, ratios, off, fmt="o", capsize=3)
        panel.axhline(DEFAULT.share, color="k", linestyle=":", linewidth=0.9)
        panel.axvline(DEFAULT.goal, color=axes.GREEN, linestyle="--", linewidth=0.9)
        panel.set(title=_words(name), xlabel="slope / deg", ylabel="share that walks on", ylim=(-0.05, 1.05))
        panel.grid(alpha=0.3)


SLOPE: Final = Experiment(
    title="R6: inclined planes, with no knowledge of the ground",
    source="Thesis 4.2.3 and chapter 5: torso control and admittance let the robot walk upright on inclined "
    "planes without the planning knowing of them. No figure and no slope is given.",
    setup=lambda measured: (
        ("gait", f"{measured.context.gait or GAIT}, with its own controllers"),
        ("length", f"{DEFAULT.duration:g} s, from a stand on the slope"),
        (
            "search",
            f"bisection in {STEP:g} degrees up to {DEFAULT.steepest:g} with up to {DEFAULT.few} seeds a "
            "slope, each until the verdict is sure; the steepest confirmed with all seeds by the lower bound "
            "of the interval",
        ),
    ),
    measure=sweep,
    quantities=_quantities,
    claims=_claims,
    tables=_table,
    pictures=(
        Drawing(
            "slope.png",
            _draw,
            "Share that walks on, by slope",
            "All slopes that were tried, with 95 % Wilson intervals; trials end as soon as the verdict is "
            "sure.",
            axes.TALL,
        ),
    ),
    findings=_findings,
)
