"""Gaits and learned policies side by side: the same seeds, wear, delays, floors and pushes."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from bridge.errors import ConfigurationError
from emulator.scenarios import Scenario
from emulator.scenarios.events import PushEvent
from emulator.scenarios.ground import ScenarioFloor, Tiles
from nao_hil.analysis.report.render import Claim, Column, ReportTable, table
from nao_hil.analysis.statistics import Paired, percent
from nao_hil.experiments.conditions import condition, pairs
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Experiment, Measured, bounded
from nao_hil.experiments.terrain import STANDS
from nao_hil.runs.walk import WalkOutcome
from walker.gaits import gait_parameters

DEFAULT: Final = ("omni", "dynamic", "onnx:imitation")
SPEED: Final = 0.08
"""m/s; of gaits that take a velocity. Straight ones walk at their own."""
DURATION: Final = 15.0
"""s"""
SLOPE: Final = 3.0
"""Degrees uphill."""
TILES: Final = 0.005
"""Largest height of a tile, m."""
FRICTION: Final = 0.5
DELAY: Final = 0.010
"""Added to the delay of the drives, s."""
PUSH: Final = 1.0
"""N s, forward and to the left, at `PUSH_AT`."""
PUSH_AT: Final = 6.0
"""s of robot time."""
TITLES: Final = {
    "nominal": "Flat floor",
    "worn": "Worn robot",
    "delay": f"Drives {1e3 * DELAY:g} ms later",
    "slope": f"{SLOPE:g} degrees uphill",
    "tiles": f"Tiles of up to {1e3 * TILES:g} mm",
    "friction": f"Friction {FRICTION:g}",
    "push ahead": f"Push of {PUSH:g} N s forward",
    "push aside": f"Push of {PUSH:g} N s to the left",
}


@dataclass(frozen=True)
class PolicyWalks:
    """Walks of all courses."""

    walks: Mapping[str, Mapping[str, list[WalkOutcome]]]
    """By course and gait."""

    def pairs(self, course: str, gait: str) -> Paired:
        """The first gait and another one on a course, seed by seed."""
        first, by_gait = next(iter(self.walks[course].values())), self.walks[course]
        return pairs(first, by_gait[gait])


def _gaits(context: Context) -> tuple[str, ...]:
    """Those given, separated by commas.

    Raises:
        ConfigurationError: one of them twice.
    """
    given = tuple(context.gait.split(",")) if context.gait else DEFAULT
    if len(set(given)) < len(given):
        raise ConfigurationError(f"--gait {context.gait}: names a gait twice; each is compared with the first.")
    return given


def _courses(context: Context) -> dict[str, dict[str, Any]]:
    """Changes and fields of the walks of each course."""
    from emulator.wear import load_wear

    seconds = context.duration or DURATION
    delay = load_wear(context.wear.replace("ensemble", "nominal"), context.body).servo.delay + DELAY
    tiles = Tiles(area=(SPEED * seconds + 1.0, 2.0), centre=(0.5 * SPEED * seconds, 0.0), height=TILES)
    worlds = {
        "slope": Scenario(floor=ScenarioFloor(pitch=-SLOPE)),
        "tiles": Scenario(tiles=tiles),
        "friction": Scenario(floor=ScenarioFloor(friction=FRICTION)),
        "push ahead": Scenario(pushes=(PushEvent(time=PUSH_AT, impulse=PUSH),)),
        "push aside": Scenario(pushes=(PushEvent(time=PUSH_AT, impulse=PUSH, direction=90.0),)),
    }
    changes: dict[str, dict[str, Any]] = {"worn": {"wear": "worn"}, "delay": {"wear.servo.delay": delay}}
    return {
        course: {
            "changes": changes.get(course, {}),
            "fields": {"keep_track": False} | ({"scenario": worlds[course]} if course in worlds else {}),
        }
        for course in TITLES
    }


def _measure(context: Context) -> PolicyWalks:
    gaits, seconds = _gaits(context), context.duration or DURATION
    names, conditions = [], []
    for course, parts in _courses(context).items():
        for gait in gaits:
            steered = gait_parameters(gait).limits is not None
            velocity = {"velocity": (SPEED, 0.0, 0.0)} if steered else {}
            task = Task(gait, seconds, velocity | parts["changes"], fields=parts["fields"])
            names.append((course, gait))
            conditions.append(task.walks(context, f"policies, {course}, {gait}"))
    found = dict(zip(names, context.run(*conditions), strict=True))
    return PolicyWalks({course: {gait: found[course, gait] for gait in gaits} for course in TITLES})


def _quantities(measured: Measured[PolicyWalks]) -> dict[str, Any]:
    walks = measured.results.walks
    others = _gaits(measured.context)[1:]
    return {
        "courses": {
            course: {gait: condition(found) for gait, found in by_gait.items()}
            for course, by_gait in walks.items()
        },
        "pairs": {course: {gait: measured.results.pairs(course, gait) for gait in others} for course in walks},
    }


def _claims(measured: Measured[PolicyWalks]) -> list[Claim]:
    nominal = measured.figures["courses"]["nominal"]
    return [bounded(f"{TITLES['nominal']}: 45 of 50 stand, {gait}", nominal[gait], STANDS) for gait in nominal]


def _table(measured: Measured[PolicyWalks]) -> list[ReportTable]:
    first, *others = _gaits(measured.context)

    def stand(item: tuple[str, dict[str, Any]], gait: str) -> str:
        found = item[1][gait]
        return f"{found.survived} of {found.n} ({percent(found.interval)})"

    def discordant(item: tuple[str, Any], gait: str) -> str:
        pair = measured.results.pairs(item[0], gait)
        return f"{pair.only_with} / {pair.only_without}, p = {pair.p_value:.2g}"

    columns: dict[str, Column] = {"course": lambda item: TITLES[item[0]]}
    for gait in (first, *others):
        columns[f"{gait}: stand"] = functools.partial(stand, gait=gait)
        columns[f"{gait}: m/s over ground"] = f"{{0[1][{gait}].speed:.3f}}"
    for gait in others:
        columns[f"only {first} / only {gait}, McNemar"] = functools.partial(discordant, gait=gait)
    return [table("Courses", measured.figures["courses"].items(), columns)]


POLICIES: Final = Experiment(
    title=lambda measured: f"Gaits and policies: {', '.join(_gaits(measured.context))}",
    source="A comparison of this project; no figures for a NAO are published.",
    setup=lambda measured: [
        ("walks", f"{SPEED:g} m/s where the gait can, {measured.context.duration or DURATION:g} s"),
        ("pairs", f"each with {_gaits(measured.context)[0]} on the same seeds"),
        ("switch", "the gait, with its own controllers"),
    ],
    measure=_measure,
    quantities=_quantities,
    claims=_claims,
    tables=_table,
)
