"""Effect of each feedback of a gait: each switched off in turn, on disturbed and undisturbed walks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import msgspec
import numpy as np

from nao_hil.analysis.report.render import Outcome, ReportTable
from nao_hil.analysis.statistics import Estimate, Paired, few_words
from nao_hil.experiments.conditions import Condition, condition, pairs
from nao_hil.experiments.context import Context
from nao_hil.experiments.terrain import TerrainSetup, ground_walks
from nao_hil.experiments.velocity import Straight, cell, straight
from nao_hil.runs.build import check_run
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.events import StridePush
from nao_hil.runs.walk import Walk
from walker.parameters import controller_parameters
from walker.switches import NAMED, Switches

SHIPPED: Final = "as shipped"
STRAIGHT: Final = "straight"


SPEED: Final = 0.15
"""m/s of walks that are pushed."""
PUSH: Final = 1.5
"""N s, in 0.1 s; direction and phase of the stride are drawn from the seed."""
STANDING_PUSH: Final = 2.3
"""N s, likewise, of a robot that stands."""
BEFORE: Final = 2.0
"""s of walk or stand before a push."""
AFTER: Final = 6.0
GROUND: Final = TerrainSetup(duration=8.0, worn_duration=8.0)
AHEAD: Final = (0.25, 0.0, 0.0)
"""m/s, m/s, rad/s of the straight walk."""
AHEAD_DURATION: Final = 8.0
"""s"""


class FeedbackCell(msgspec.Struct, frozen=True, kw_only=True):
    """One condition of one task."""

    task: str
    condition: str
    result: Condition
    against_shipped: Paired


def experiment(context: Context) -> Outcome:
    """All tasks with the shipped switches and without each, seed by seed."""
    gait = context.gait or "omni"
    walks = {
        (task, name): _named(f"feedback, {task}, {name}", make(_changed(context, gait, switches)))
        for task, make in _tasks(gait).items()
        for name, switches in _conditions(context, gait).items()
    }
    for task in _tasks(gait):
        check_run(walks[task, SHIPPED][0].config)  # refuses a velocity beyond the gait before the first walk
    mixed = [walk for of_seed in zip(*walks.values(), strict=True) for walk in of_seed]
    done = context.walk_by_name(mixed)
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
    speed = {name: cell(AHEAD, results, (1.0, 1.0, 1.0)).ratio for name, results in ahead.items()}
    line = {name: straight(results) for name, results in ahead.items()}
    return context.outcome(
        "feedback",
        f"Each feedback of the gait {gait} switched off in turn{few_words(len(context.seeds))}",
        "No such table has been published for a NAO.",
        setup=[("walks", _words()), ("switch", "the one that is named")],
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


def _tasks(gait: str) -> Mapping[str, Callable[[Context], list[Walk]]]:
    def ground(name: str) -> Callable[[Context], list[Walk]]:
        return lambda context: ground_walks(context, GROUND, name, gait)

    def ahead(context: Context) -> list[Walk]:
        return context.walks("", gait, AHEAD_DURATION, velocity=AHEAD)

    return {
        "push": lambda context: _pushed(context, gait, stand=False),
        "push in a stand": lambda context: _pushed(context, gait, stand=True),
        **{name: ground(name) for name in ("plates", "slope", "worn")},
        STRAIGHT: ahead,
    }


def _pushed(context: Context, gait: str, *, stand: bool) -> list[Walk]:
    walks = context.walks("", gait, BEFORE + AFTER, velocity=(SPEED, 0.0, 0.0), stand=stand, keep_track=False)
    return [msgspec.structs.replace(walk, pushes=(_push(walk.config.seed, stand),)) for walk in walks]


def _push(seed: int, stand: bool) -> StridePush:
    direction, phase = np.random.default_rng([seed, 3]).uniform((0.0, 0.0), (math.tau, 1.0)).tolist()
    return StridePush(
        time=BEFORE,
        phase=None if stand else phase,
        impulse=STANDING_PUSH if stand else PUSH,
        direction=direction,
    )


def _words() -> str:
    return (
        f"push: {PUSH:g} N s at {SPEED:g} m/s, {STANDING_PUSH:g} N s in a stand, any "
        f"direction and phase; plates, slope and worn as in `terrain`, {GROUND.duration:g} s; "
        f"straight: {AHEAD[0]:g} m/s, {AHEAD_DURATION:g} s"
    )


def _table(cells: Sequence[FeedbackCell], speed: dict[str, Estimate], line: dict[str, Straight]) -> ReportTable:
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
            speed[name].words(digits=2),
            line[name].heading_deg.words(digits=1),
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
