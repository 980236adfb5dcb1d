"""What each feedback of a gait is good for: each switched off in turn, on disturbed and undisturbed walks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import msgspec
import numpy as np

from nao_hil.analysis.report.page import Outcome, ReportPage, ReportTable
from nao_hil.analysis.statistics import Paired, few_words
from nao_hil.experiments.arms import Arm, arm, pairs
from nao_hil.experiments.context import Context
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.terrain import TerrainSetup, ground_walks
from nao_hil.experiments.velocity_measure import MeanInterval, Straight, cell, straight
from nao_hil.runs.build import check_run
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.events import StridePush
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.parameters import controller_parameters
from walker.switches import NAMED, Switches

SHIPPED: Final = "as shipped"
STRAIGHT: Final = "straight"


@dataclass(frozen=True)
class FeedbackSetup:
    """The experiment's numbers, SI units."""

    speed: float = 0.15
    """Of walks that are pushed."""
    push: float = 1.5
    """N s, in 0.1 s; direction and phase of the stride are drawn from the seed."""
    standing_push: float = 2.3
    """N s, likewise, of a robot that stands."""
    before: float = 2.0
    """s of walk or stand before a push."""
    after: float = 6.0
    ground: TerrainSetup = field(default_factory=lambda: TerrainSetup(duration=8.0, worn_duration=8.0))
    straight: float = 0.25
    straight_duration: float = 8.0


class FeedbackCell(msgspec.Struct, frozen=True, kw_only=True):
    """One arm of one task."""

    task: str
    arm: str
    result: Arm
    against_shipped: Paired


class FeedbackResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "feedback"
    passed: bool = True
    """A table claims nothing."""
    gait: str
    cells: tuple[FeedbackCell, ...]
    speed: dict[str, MeanInterval]
    """Measured over commanded straight ahead, by arm."""
    straight: dict[str, Straight]
    """Heading and odometry of the same walks, by arm."""


def experiment(context: Context, setup: FeedbackSetup | None = None) -> Outcome:
    """All tasks with the shipped switches and without each, seed by seed."""
    setup, gait = setup or FeedbackSetup(), context.gait or "omni"
    walks = {
        (task, name): _named(f"feedback, {task}, {name}", make(_changed(context, gait, switches)))
        for task, make in _tasks(setup, gait).items()
        for name, switches in _arms(context, gait).items()
    }
    for task in _tasks(setup, gait):
        check_run(walks[task, SHIPPED][0].config)  # a velocity beyond the gait is told before the first walk
    mixed = [walk for of_seed in zip(*walks.values(), strict=True) for walk in of_seed]
    done: dict[str, list[WalkOutcome]] = {}
    for outcome in context.campaign.walk(mixed):
        done.setdefault(outcome.walk.name, []).append(outcome)
    found = {key: done.get(each[0].name, []) for key, each in walks.items()}
    if not all(found.values()):
        raise Interrupted
    cells = tuple(
        FeedbackCell(
            task=task, arm=name, result=arm(results), against_shipped=pairs(results, found[task, SHIPPED])
        )
        for (task, name), results in found.items()
    )
    ahead = {name: results for (task, name), results in found.items() if task == STRAIGHT}
    command = (setup.straight, 0.0, 0.0)
    result = FeedbackResult(
        gait=gait,
        cells=cells,
        speed={name: cell(command, results, (1.0, 1.0, 1.0)).ratio for name, results in ahead.items()},
        straight={name: straight(results) for name, results in ahead.items()},
    )
    page = ReportPage(
        name="feedback",
        title=f"Each feedback of the gait {gait} switched off in turn{few_words(len(context.seeds))}",
        source="No such table has been published for a NAO.",
        setup=setup_rows(context, [("walks", _words(setup)), ("switch", "the one that is named")]),
        claims=(),
        tables=(_table(result),),
    )
    return Outcome(result, page)


def _arms(context: Context, gait: str) -> dict[str, Switches]:
    shipped = controller_parameters(gait, context.config(gait, 0, {}).controller).switches
    off = NAMED["none"]
    found = {SHIPPED: shipped}
    for name in Switches.__struct_fields__:
        if getattr(shipped, name) != getattr(off, name):
            found[f"without {name}"] = msgspec.structs.replace(shipped, **{name: getattr(off, name)})
    return found


def _changed(context: Context, gait: str, switches: Switches) -> Context:
    config = context.config(gait, 0, msgspec.to_builtins(switches))
    changes = msgspec.structs.replace(context.changes, gait=gait, controller=config.controller)
    return replace(context, changes=changes)


def _named(name: str, walks: Sequence[Walk]) -> list[Walk]:
    return [msgspec.structs.replace(walk, name=name) for walk in walks]


def _tasks(setup: FeedbackSetup, gait: str) -> Mapping[str, Callable[[Context], list[Walk]]]:
    def ground(name: str) -> Callable[[Context], list[Walk]]:
        return lambda context: ground_walks(context, setup.ground, name, gait)

    def ahead(context: Context) -> list[Walk]:
        return context.walks("", gait, setup.straight_duration, velocity=(setup.straight, 0.0, 0.0))

    return {
        "push": lambda context: _pushed(context, setup, gait, stand=False),
        "push in a stand": lambda context: _pushed(context, setup, gait, stand=True),
        **{name: ground(name) for name in ("plates", "slope", "worn")},
        STRAIGHT: ahead,
    }


def _pushed(context: Context, setup: FeedbackSetup, gait: str, *, stand: bool) -> list[Walk]:
    walks = context.walks(
        "", gait, setup.before + setup.after, velocity=(setup.speed, 0.0, 0.0), stand=stand, keep_track=False
    )
    return [msgspec.structs.replace(walk, pushes=(_push(setup, walk.config.seed, stand),)) for walk in walks]


def _push(setup: FeedbackSetup, seed: int, stand: bool) -> StridePush:
    direction, phase = np.random.default_rng([seed, 3]).uniform((0.0, 0.0), (math.tau, 1.0)).tolist()
    return StridePush(
        time=setup.before,
        phase=None if stand else phase,
        impulse=setup.standing_push if stand else setup.push,
        direction=direction,
    )


def _words(setup: FeedbackSetup) -> str:
    return (
        f"push: {setup.push:g} N s at {setup.speed:g} m/s, {setup.standing_push:g} N s in a stand, any "
        f"direction and phase; plates, slope and worn as in `terrain`, {setup.ground.duration:g} s; "
        f"straight: {setup.straight:g} m/s, {setup.straight_duration:g} s"
    )


def _table(result: FeedbackResult) -> ReportTable:
    """Of each arm how many stood, and in brackets those that stood with it only and without it only."""
    tasks = list(dict.fromkeys(each.task for each in result.cells))
    cells = {(each.task, each.arm): each for each in result.cells}
    rows = []
    for name in result.speed:
        stood = [_stood(cells[task, name]) for task in tasks]
        heading = result.straight[name].heading_deg.words(1.0, 1)
        rows.append((name, *stood, result.speed[name].words(), heading))
    return ReportTable(
        "Walks that stood (with this arm only / as shipped only)",
        ("arm", *tasks, "straight: measured over commanded", "change of heading, deg"),
        tuple(rows),
    )


def _stood(found: FeedbackCell) -> str:
    text, pair = f"{found.result.survived} of {found.result.n}", found.against_shipped
    return text if found.arm == SHIPPED else f"{text} ({pair.only_with} / {pair.only_without})"
