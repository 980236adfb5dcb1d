"""R6: the steepest slope in each of four directions that the robot walks on, not knowing of it (4.2.3, ch. 5).

Swept in half degrees by bisection. Each slope is tried with a few seeds, in order, until its verdict is
sure; the steepest that passes is then confirmed with all seeds, and half a degree less taken if it fails.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from emulator.scenarios import Scenario
from emulator.scenarios.ground import ScenarioFloor
from nao_hil.analysis.report.render import Claim, Outcome, Picture, ReportTable
from nao_hil.analysis.statistics import Share, percent, wilson
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import falls_finding
from nao_hil.experiments.context import Context
from nao_hil.files import save_figure
from nao_hil.runs.walk import Walk, WalkOutcome

STEP: Final = 0.5
"""Degrees"""
GAIT: Final = "static"
"""Of the thesis; another one with `--gait`."""
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


class Slope(Share, frozen=True, kw_only=True):
    """The steepest slope of one direction at which enough walk on."""

    slope_deg: float


Request = tuple[float, tuple[int, ...]]
"""A slope in degrees and the seeds to try it with."""


Search = Generator[Request, Sequence[bool], float]


@dataclass
class Tally:
    """Trials of one direction."""

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


def experiment(context: Context, setup: SlopeSetup | None = None) -> Outcome:
    """Search all four directions at once."""
    setup = setup or SlopeSetup()
    gait = context.gait or GAIT
    found, tallies = _sweep(context, setup, gait)
    slopes = {}
    for name, slope in found.items():
        survived, n = tallies[name].count(slope)
        slopes[name] = Slope(slope_deg=slope, n=n, survived=survived)
    return context.outcome(
        "slope",
        "R6: inclined planes, with no knowledge of the ground",
        "Thesis 4.2.3 and chapter 5: torso control and admittance let the robot walk upright on inclined "
        "planes without the planning knowing of them. No figure and no slope is given.",
        setup=[
            ("gait", f"{gait}, with its own controllers"),
            ("length", f"{setup.duration:g} s, from a stand on the slope"),
            (
                "search",
                f"bisection in {STEP:g} degrees up to {setup.steepest:g} with up to {setup.few} seeds a "
                "slope, each until the verdict is sure; the steepest confirmed with all seeds by the lower "
                "bound of the interval",
            ),
        ],
        claims=[
            Claim(
                f"{_words(name)}: {setup.goal:g} degrees or more at {100 * setup.share:.0f} %",
                f"{s.slope_deg:g} deg ({s.words()})",
                s.slope_deg >= setup.goal and s.interval[0] >= setup.share,
            )
            for name, s in slopes.items()
        ],
        pictures=[
            Picture(
                _plot(context.out / "slope.png", tallies, setup),
                "Share that walks on, by slope",
                "All slopes that were tried, with 95 % Wilson intervals; trials end as soon as the verdict "
                "is sure.",
            )
        ],
        tables=[_table(tallies)],
        findings=[_finding(name, found[name], tallies[name]) for name in DIRECTIONS],
        figures=slopes,
    )


def _sweep(context: Context, setup: SlopeSetup, gait: str) -> tuple[dict[str, float], dict[str, Tally]]:
    """Advance the searches of all directions together: each round is one batch for the workers."""
    searches = {name: search(context.seeds, setup) for name in DIRECTIONS}
    tallies = {name: Tally() for name in DIRECTIONS}
    found: dict[str, float] = {}
    wanted = {name: next(steps) for name, steps in searches.items()}
    while wanted:
        walks = [
            walk
            for name, (slope, seeds) in wanted.items()
            for walk in _walks(context, setup, gait, name, slope, seeds)
        ]
        results = {(r.walk.name, r.seed): r for r in context.walk_all(walks)}
        for name, (slope, seeds) in list(wanted.items()):
            runs = {seed: results[_name(name, slope), seed] for seed in seeds}
            tallies[name].runs.setdefault(slope, {}).update(runs)
            try:
                wanted[name] = searches[name].send([runs[seed].end.survived for seed in seeds])
            except StopIteration as stop:
                found[name] = stop.value
                del wanted[name]
    return {name: found[name] for name in DIRECTIONS}, tallies


def _walks(
    context: Context, setup: SlopeSetup, gait: str, name: str, slope: float, seeds: Sequence[int]
) -> list[Walk]:
    roll, pitch = (slope * part for part in DIRECTIONS[name])
    return [
        Walk(
            name=_name(name, slope),
            config=context.config(gait, seed, {}),
            duration=setup.duration,
            scenario=Scenario(floor=ScenarioFloor(roll=roll, pitch=pitch)),
            keep_track=False,
        )
        for seed in seeds
    ]


def _name(direction: str, slope: float) -> str:
    return f"slope, {direction}, {slope:g} deg"


def _words(name: str) -> str:
    return {"up": "Uphill", "down": "Downhill"}.get(name, f"Across, the {name} side higher")


def _finding(name: str, slope: float, tally: Tally) -> str:
    """Falls on the next steeper slope of the search."""
    steeper = sorted(s for s in tally.runs if s > slope)
    if not steeper:
        return ""
    results = list(tally.runs[steeper[0]].values())
    return falls_finding(f"{_words(name)} at {steeper[0]:g} deg", results, None)


def _table(tallies: dict[str, Tally]) -> ReportTable:
    rows = tuple(
        (_words(name), f"{slope:g}", f"{survived} of {n}", percent(wilson(survived, n)))
        for name, tally in tallies.items()
        for slope in sorted(tally.runs)
        for survived, n in (tally.count(slope),)
    )
    return ReportTable("Slopes tried", ("direction", "slope, deg", "walk on", "95 % interval"), rows)


def _plot(path: Path, tallies: dict[str, Tally], setup: SlopeSetup) -> Path:
    figure = axes.new_figure(9.0, 6.0)
    panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel().tolist()
    for panel, (name, tally) in zip(panels, tallies.items(), strict=True):
        slopes = sorted(tally.runs)
        shares, lows, highs = [], [], []
        for slope in slopes:
            survived, n = tally.count(slope)
            share, (low, high) = survived / n, wilson(survived, n)
            shares.append(share)
            lows.append(share - low)
            highs.append(high - share)
        panel.errorbar(slopes, shares, (lows, highs), fmt="o", capsize=3)
        panel.axhline(setup.share, color="k", linestyle=":", linewidth=0.9)
        panel.axvline(setup.goal, color=axes.GREEN, linestyle="--", linewidth=0.9)
        panel.set(title=_words(name), xlabel="slope / deg", ylabel="share that walks on", ylim=(-0.05, 1.05))
        panel.grid(alpha=0.3)
    return save_figure(figure, path)
