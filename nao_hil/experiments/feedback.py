"""Effect of each feedback of a gait: each switched off in turn, on disturbed and undisturbed walks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import msgspec
import numpy as np

from nao_hil.analysis.report.render import Outcome, ReportTable
from nao_hil.analysis.statistics import Paired, few_words
from nao_hil.experiments.conditions import Condition, condition, pairs
from nao_hil.experiments.context import Context
from nao_hil.experiments.terrain import TerrainSetup, ground_walks
from nao_hil.experiments.velocity import MeanInterval, Straight, cell, straight
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
    """One condition of one task."""

    task: str
    condition: str
    result: Condition
    against_shipped: Paired


def experiment(context: Context, setup: FeedbackSetup | None = None) -> Outcome:
    """All tasks with the shipped switches and without each, seed by seed."""
    setup, gait = setup or FeedbackSetup(), context.gait or "omni"
    walks = {
        (task, name): _named(f"feedback, {task}, {name}", make(_changed(context, gait, switches)))
        for task, make in _tasks(setup, gait).items()
        for name, switches in _conditions(context, gait).items()
    }
    for task in _tasks(setup, gait):
        check_run(walks[task, SHIPPED][0].config)  # refuses a velocity beyond the gait before the first walk
    mixed = [walk for of_seed in zip(*walks.values(), strict=True) for walk in of_seed]
    done: dict[str, list[WalkOutcome]] = {}
    for outcome in context.campaign.walk(mixed):
        done.setdefault(outcome.walk.name, []).append(outcome)
    found = {key: done.get(each[0].name, []) for key, each in walks.items()}
    if not all(found.values()):
        raise Interrupted
    cells = [
        FeedbackCell(
            task=task,
            condition=name,
            result=condition(results),
            against_shipped=pairs(results, found[task, SHIPPED]),
        )
        for (task, name), results in found.items()
    ]
    ahead = {name: results for (task, name), results in found.items() if task == STRAIGHT}
    command = (setup.straight, 0.0, 0.0)
    speed = {name: cell(command, results, (1.0, 1.0, 1.0)).ratio for name, results in ahead.items()}
    line = {name: straight(results) for name, results in ahead.items()}
    return context.outcome(
        "feedback",
        f"Each feedback of the gait {gait} switched off in turn{few_words(len(context.seeds))}",
        "No such table has been published for a NAO.",
        setup=[("walks", _words(setup)), ("switch", "the one that is named")],
        tables=[_table(cells, speed, line)],
        figures={"gait": gait, "cells": cells, "speed": speed, "straight": line},
    )


def _conditions(context: Context, gait: str) -> dict[str, Switches]:
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


def _table(
    cells: Sequence[FeedbackCell], speed: dict[str, MeanInterval], line: dict[str, Straight]
) -> ReportTable:
    """Walks of each condition that stood, and in brackets those that stood with it only and without it only.

    Args:
        cells: Of all tasks and conditions.
        speed: Measured over commanded straight ahead, by condition.
        line: Heading and odometry of the same walks, by condition.
    """
    tasks = list(dict.fromkeys(each.task for each in cells))
    by_name = {(each.task, each.condition): each for each in cells}
    rows = tuple(
        (
            name,
            *(_stood(by_name[task, name]) for task in tasks),
            speed[name].words(),
            line[name].heading_deg.words(1.0, 1),
        )
        for name in speed
    )
    return ReportTable(
        "Walks that stood (with this condition only / as shipped only)",
        ("condition", *tasks, "straight: measured over commanded", "change of heading, deg"),
        rows,
    )


def _stood(found: FeedbackCell) -> str:
    text, pair = f"{found.result.survived} of {found.result.n}", found.against_shipped
    return text if found.condition == SHIPPED else f"{text} ({pair.only_with} / {pair.only_without})"
