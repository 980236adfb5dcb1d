"""Where R1, R2 and R5 hold together: a search within the bounds of what the thesis leaves open.

Half of the seeds search: each point of a Sobol' sequence walks R5 with torso control, which fails as shipped.
The other half judges: the best points walk R1 (to the second landing), R2 and R5, each with its condition and
without.
"""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Final

import msgspec
from scipy.stats import qmc, spearmanr

from bridge.errors import ConfigurationError
from nao_hil.analysis.report.render import Outcome, ReportTable
from nao_hil.analysis.statistics import wilson
from nao_hil.experiments import obstacle, torso_control
from nao_hil.experiments.context import Context, Task
from nao_hil.runs.build import check_run
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.gaits import gait_parameters

POINTS: Final = 16
"""Of the search, beside the shipped one; a power of two."""
BEST: Final = 2
"""Points that are judged, beside the shipped one."""
SEARCH_DURATION: Final = 20.0
"""s of the walks of the search."""
BOARD_DURATION: Final = 23.0
"""The same of R1."""


@dataclass(frozen=True)
class Open:
    """A quantity that the text leaves open."""

    low: float
    high: float
    shipped: float
    source: str
    log: bool = False

    def at(self, share: float) -> float:
        """The value at a share of the range."""
        if self.log:
            return self.low * (self.high / self.low) ** share
        return self.low + share * (self.high - self.low)


OPEN: Final = {
    "D": Open(
        73.0, 560.0, 280.0, "5 N of figure 4.1 at 0.065 m/s; 70 N for 20 ms within 2.5 mm", log=True
    ),  # N s/m
    "start": Open(0.0, 0.9, 0.5, "share of the swing from which the force counts: not given"),
    "length": Open(0.05, 0.091, 0.091, "of a step, m: 5 to 10 cm (1.2.2); beyond the ankles do not reach"),
    "sway": Open(0.022, 0.030, 0.030, "e_s1, m: up to the printed one; the ankles allow no more"),
    "lift": Open(0.010, 0.035, 0.025, "of the dynamic gait, m: not given, up to the static gait's"),
    "floor": Open(8e6, 1e8, 6e7, "stiffness under the sole, N/m^3: the range of `hard_floor`", log=True),
    "friction": Open(0.6, 0.9, 0.8, "wood 0.8, carpet 0.9; worn soles less"),
}

SHIPPED: Final = {name: each.shipped for name, each in OPEN.items()}


def quantities(point: dict[str, float], gait: str) -> dict[str, Any]:
    """The point as quantities of `nao_hil.campaigns`.

    Args:
        point: By name of `OPEN`.
        gait: Length, sway and lift are the dynamic gait's.
    """
    if point == SHIPPED:
        return {}
    table: dict[str, Any] = {
        "controller.leg.D": point["D"],
        "controller.leg.start": point["start"],
        "scenario.floor.stiffness": point["floor"],
        "scenario.floor.friction": point["friction"],
    }
    if gait == "static":
        return table
    plan = gait_parameters("dynamic", {"e_s1": point["sway"]})
    ahead = point["length"] * plan.S_a0 / plan.periodic_step.length  # proportional
    return table | {
        "parameters.e_s1": point["sway"],
        "parameters.S_a0": ahead,
        "parameters.l_lift": point["lift"],
    }


def points() -> list[dict[str, float]]:
    """The shipped point, then those of the search."""
    shares = qmc.Sobol(len(OPEN), seed=0).random(POINTS).tolist()
    return [SHIPPED, *({n: o.at(s) for (n, o), s in zip(OPEN.items(), row, strict=True)} for row in shares)]


def walks(context: Context, experiment: str, point: dict[str, float], condition: str) -> list[Walk]:
    """A condition of an experiment at a point, a walk per seed."""
    gait = "dynamic" if experiment.startswith("R5") else "static"
    task = Task(gait, torso_control.DURATION, torso_control.SWITCHES[condition], fields={"keep_track": False})
    if experiment == "R1":
        switches = obstacle.SWITCHES[condition]
        task = task._replace(duration=BOARD_DURATION, changes=switches, by_seed=obstacle.board)
    elif experiment == "R5, search":
        task = task._replace(duration=SEARCH_DURATION)
    return task.walks(context, f"{experiment}, {condition}, {describe(point)}", quantities(point, gait))


def describe(point: dict[str, float]) -> str:
    """The point in words."""
    if point == SHIPPED:
        return "as shipped"
    return ", ".join(f"{name} {value:.3g}" for name, value in point.items())


class Judged(msgspec.Struct, frozen=True, kw_only=True):
    """An experiment at a point, on seeds that did not choose it."""

    with_: tuple[int, int]
    """Walks that stood to the end, and all."""
    without: tuple[int, int]
    time_with: float
    """Median time that they stood, s."""
    time_without: float


def experiment(context: Context) -> Outcome:
    """Both halves, and the map."""
    half = len(context.seeds) // 2
    search, judge = context.first(half), replace(context, seeds=context.seeds[half:])
    tried = [p for p in points() if _can_be_walked(search, p)]
    of_points = [walks(search, "R5, search", p, "with") for p in tried]
    found = search.walk_by_name([walk for of_seed in zip(*of_points, strict=True) for walk in of_seed])
    times = [_times(found.get(f"R5, search, with, {describe(p)}", [])) for p in tried]
    order = sorted(range(1, len(tried)), key=lambda k: -statistics.median(times[k] or [0.0]))
    judged: dict[str, dict[str, Judged]] = {}
    with suppress(Interrupted):  # the search stands without the rest
        for k in [*order[:BEST], 0]:
            of = judged.setdefault(describe(tried[k]), {})
            for name in ("R5", "R1", "R2"):
                of[name] = _judge(judge, name, tried[k])
    rows = [(p, statistics.median(each), each) for p, each in zip(tried, times, strict=True) if each]
    searched = [row for row in rows if row[0] != SHIPPED]
    medians = [median for _, median, _ in searched]
    effects = {name: float(spearmanr([p[name] for p, _, _ in searched], medians).statistic) for name in OPEN}
    walked = [time for _, _, of in searched for time in of]
    stood, number = sum(time >= SEARCH_DURATION - 1e-6 for time in walked), len(walked)
    return context.outcome(
        "thesis-map",
        f"R1, R2 and R5 over what the text leaves open ({POINTS} points)",
        "Thesis 4.1.1, 4.2 and 4.2.3; bounds as named below.",
        setup=[(name, f"{o.low:g} to {o.high:g}; {o.source}") for name, o in OPEN.items()],
        tables=[
            ReportTable(
                f"R5 with torso control: time, s, of {SEARCH_DURATION:g}; {len(search.seeds)} walks each",
                (*OPEN, "median", "least", "most"),
                tuple(
                    (*(f"{p[name]:.3g}" for name in OPEN), *(f"{v:.1f}" for v in (m, min(t), max(t))))
                    for p, m, t in sorted(rows, key=lambda row: -row[1])
                ),
            ),
            ReportTable(
                f"Judged on {len(judge.seeds)} other seeds: stood with / without, median times, s",
                ("point", "R5", "R1", "R2"),
                tuple(
                    (name, *(_words(of[each]) if each in of else "" for each in ("R5", "R1", "R2")))
                    for name, of in judged.items()
                ),
            ),
        ],
        findings=[
            f"{POINTS + 1 - len(tried)} of {POINTS} points are beyond the ankles' range and were left out.",
            f"R5 stands {SEARCH_DURATION:g} s in {stood} of {number} walks ({_interval(stood, number)}); "
            f"as shipped it stands {rows[0][1]:.1f} s, at the best point {max(medians):.1f} s (medians).",
            "Rank correlation of the time with each quantity: "
            + ", ".join(f"{name} {value:+.2f}" for name, value in effects.items())
            + ".",
        ],
        figures={
            "points": tried,
            "times": times,  # s, by point, of the search
            "effects": effects,
            "judged": judged,
        },
    )


def _can_be_walked(context: Context, point: dict[str, float]) -> bool:
    try:
        check_run(walks(context, "R5", point, "with")[0].config)
    except ConfigurationError:
        return False
    return True


def _times(outcomes: Sequence[WalkOutcome]) -> list[float]:
    return [outcome.end.time for outcome in outcomes]


def _judge(context: Context, name: str, point: dict[str, float]) -> Judged:
    with_, without = (context.walk_all(walks(context, name, point, each)) for each in ("with", "without"))
    return Judged(
        with_=(sum(each.end.survived for each in with_), len(with_)),
        without=(sum(each.end.survived for each in without), len(without)),
        time_with=statistics.median(_times(with_)),
        time_without=statistics.median(_times(without)),
    )


def _words(found: Judged) -> str:
    return (
        f"{found.with_[0]} / {found.without[0]} of {found.with_[1]}; "
        f"{found.time_with:.1f} / {found.time_without:.1f}"
    )


def _interval(k: int, n: int) -> str:
    low, high = wilson(k, n)
    return f"{100.0 * low:.0f} to {100.0 * high:.0f} %"
