"""R6: the steepest slope in each of four directions that the robot walks on, not knowing of it (4.2.3, ch. 5).

Swept in half degrees by bisection. Each slope is tried with a few seeds, in order, until it is sure which way
it goes; the steepest that passes is then confirmed with all seeds, and half a degree less taken if it fails.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import msgspec

from emulator.scenarios import Scenario
from emulator.scenarios.ground import ScenarioFloor
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage, ReportTable
from nao_hil.analysis.statistics import wilson
from nao_hil.experiments import axes
from nao_hil.experiments.arms import falls_finding
from nao_hil.experiments.context import Context
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.slope_search import STEP, Slope, SlopeSetup, Tally, search
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.walk import Walk

GAIT: Final = "static"
"""Of the thesis; another one with `--gait`."""
DIRECTIONS: Final[dict[str, tuple[float, float]]] = {
    "up": (0.0, -1.0),
    "down": (0.0, 1.0),
    "left": (1.0, 0.0),
    "right": (-1.0, 0.0),
}
"""Roll and pitch of the floor per degree of slope. `left`: across the slope, the left side higher."""


class SlopeResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "slope"
    passed: bool
    up: Slope
    down: Slope
    left: Slope
    right: Slope
    """Across the slope, the right side higher."""


def experiment(context: Context, setup: SlopeSetup | None = None) -> Outcome:
    """Search all four directions at once."""
    setup = setup or SlopeSetup()
    gait = context.gait or GAIT
    found, tallies = _sweep(context, setup, gait)
    slopes = {}
    for name, slope in found.items():
        survived, n = tallies[name].count(slope)
        slopes[name] = Slope(slope_deg=slope, n=n, survived=survived, interval=wilson(survived, n))
    claims = tuple(
        Claim(
            f"{_words(name)}: {setup.goal:g} degrees or more at {100 * setup.share:.0f} %",
            f"{s.slope_deg:g} deg ({s.survived} of {s.n}, {100 * s.interval[0]:.0f} to "
            f"{100 * s.interval[1]:.0f} %)",
            s.slope_deg >= setup.goal and s.interval[0] >= setup.share,
        )
        for name, s in slopes.items()
    )
    result = SlopeResult(
        passed=all(claim.holds for claim in claims),
        up=slopes["up"],
        down=slopes["down"],
        left=slopes["left"],
        right=slopes["right"],
    )
    page = ReportPage(
        name="slope",
        title="R6: inclined planes, with no knowledge of the ground",
        source=(
            "Thesis 4.2.3 and chapter 5: torso control and admittance let the robot walk upright on "
            "inclined planes without the planning knowing of them. No figure and no slope is given."
        ),
        setup=setup_rows(
            context,
            [
                ("gait", f"{gait}, with its own controllers"),
                ("length", f"{setup.duration:g} s, from a stand on the slope"),
                (
                    "search",
                    f"bisection in {STEP:g} degrees up to {setup.steepest:g} with up to {setup.few} seeds a "
                    "slope, each until the verdict is sure; the steepest confirmed with all seeds by the lower "
                    "bound of the interval",
                ),
            ],
        ),
        claims=claims,
        pictures=(
            Picture(
                _plot(context.out / "slope.png", tallies, setup),
                "Share that walks on, by slope",
                "All slopes that were tried, with 95 % Wilson intervals; trials end as soon as the verdict "
                "is sure.",
            ),
        ),
        tables=(_table(tallies),),
        findings=tuple(text for name in DIRECTIONS if (text := _finding(name, found[name], tallies[name]))),
    )
    return Outcome(result, page)


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
        results = {(r.walk.name, r.seed): r for r in context.campaign.walk(walks)}
        if len(results) < len(walks):
            raise Interrupted
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
    """How the robot falls on the next steeper slope that was tried."""
    steeper = sorted(s for s in tally.runs if s > slope)
    if not steeper:
        return ""
    results = list(tally.runs[steeper[0]].values())
    return falls_finding(f"{_words(name)} at {steeper[0]:g} deg", results, None)


def _table(tallies: dict[str, Tally]) -> ReportTable:
    rows = []
    for name, tally in tallies.items():
        for slope in sorted(tally.runs):
            survived, n = tally.count(slope)
            low, high = wilson(survived, n)
            rows.append(
                (_words(name), f"{slope:g}", f"{survived} of {n}", f"{100 * low:.0f} to {100 * high:.0f} %")
            )
    return ReportTable("Slopes tried", ("direction", "slope, deg", "walk on", "95 % interval"), tuple(rows))


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
    return axes.save(figure, path)
