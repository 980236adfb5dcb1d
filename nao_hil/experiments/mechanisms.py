"""Which mechanism holds the walk: each switch taken out in turn, and each alone, on disturbed walks.

`ablation` does so for the thesis' gaits, on shortened forms of R1, R2 and R5; `feedback` for one gait, on
pushes, grounds and wear. Every condition differs in one switch from the one that it is compared with.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from itertools import zip_longest
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np

from nao_hil.analysis.report.render import Column, ReportTable, table
from nao_hil.analysis.statistics import Paired, percent
from nao_hil.experiments.conditions import Condition, condition, pairs
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Experiment, Measured
from nao_hil.experiments.obstacle import HEIGHT, board
from nao_hil.experiments.terrain import ground_tasks
from nao_hil.experiments.velocity import cell, straight
from nao_hil.runs.build import check_run
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.events import StridePush
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.parameters import controller_parameters
from walker.switches import NAMED, Switches

SHIPPED: Final = "as shipped"
THESIS: Final = "the thesis' alone"
NONE: Final = "none"
DEPENDENT: Final = (
    *("common_ankle_tilt", "attitude_correction", "gyroscope_lean"),
    *("foothold_feedback", "foot_placement", "capture_step", "heading_hold", "velocity_hold", "lean_feedback"),
    "step_hold",
)
"""Switches that alone do nothing here: they act on another mechanism's offsets or input, or on `Plan.pendulum`,
which neither gait gives, or have no gains in these gaits."""


class SwitchCondition(NamedTuple):
    """One choice of switches."""

    switches: Switches
    compared: str = ""
    """Condition that differs in one switch, to be read against; empty: none."""


class Cell(msgspec.Struct, frozen=True, kw_only=True):
    """One condition of one task."""

    task: str
    condition: str
    switches: Switches
    compared: str
    """Condition that differs in one switch; empty: none."""
    result: Condition
    against_shipped: Paired


def shipped_switches(context: Context, gait: str) -> Switches:
    """Switches of a gait, with the context's changes."""
    return controller_parameters(gait, context.config(gait).controller).switches


def each_out(shipped: Switches) -> dict[str, SwitchCondition]:
    """The shipped switches, and these without each in turn."""
    on = [name for name in Switches.__struct_fields__ if getattr(shipped, name) != _off(name)]
    out = {f"without {name}": SwitchCondition(_with(shipped, name, _off(name)), SHIPPED) for name in on}
    return {SHIPPED: SwitchCondition(shipped)} | out


def each_alone() -> dict[str, SwitchCondition]:
    """No mechanism, and each alone that does something by itself."""
    conditions = {NONE: SwitchCondition(NAMED["none"])}
    for name in Switches.__struct_fields__:
        for value in () if name in DEPENDENT else ("thesis", "robust") if name == "torso" else (True,):
            title = f"torso = {value} alone" if name == "torso" else f"{name} alone"
            conditions[title] = SwitchCondition(_with(NAMED["none"], name, value), NONE)
    return conditions


def _off(name: str) -> Any:
    return getattr(NAMED["none"], name)


def _with(switches: Switches, name: str, value: Any) -> Switches:
    return msgspec.structs.replace(switches, **{name: value})


Results = Mapping[tuple[str, str], tuple[SwitchCondition, list[WalkOutcome]]]
"""By task and condition."""


def _walk_all(
    context: Context,
    tasks: Mapping[str, Task],
    planned: Mapping[tuple[str, str], SwitchCondition],
    prefix: str = "",
) -> Results:
    """Walk all conditions of all tasks in the given order, seed by seed; after a stop, those with a run."""
    walks = {
        key: tasks[key[0]].walks(
            context, f"{prefix}{key[0]}, {key[1]}", {"controller.switches": msgspec.to_builtins(each.switches)}
        )
        for key, each in planned.items()
    }
    for task in tasks:
        check_run(walks[task, SHIPPED][0].config)  # refuses a velocity beyond the gait before the first walk
    mixed = [walk for of_seed in zip_longest(*walks.values()) for walk in of_seed]
    done = context.walk_by_name(mixed)
    return {
        key: (planned[key], found)
        for key, each in walks.items()
        if (found := done.get(each[0].name)) is not None
    }


def _cells(results: Results) -> list[Cell]:
    return [
        Cell(
            task=task,
            condition=name,
            switches=of.switches,
            compared=of.compared,
            result=condition(found),
            against_shipped=pairs(found, results[task, SHIPPED][1]),
        )
        for (task, name), (of, found) in results.items()
        if (task, SHIPPED) in results
    ]


# ablation: the thesis' gaits

_BOARD_TIME: Final = 3.0
"""s of the walk at which the board of R1 is put under the right foot."""
_FIELDS: Final = {"keep_track": False}
ABLATION_TASKS: Final = {
    "R5: dynamic gait": Task("dynamic", 15.0, fields=_FIELDS),
    "R2: static gait": Task("static", 30.0, fields=_FIELDS),
    "R1: static gait, board": Task(
        "static", 18.0, by_seed=functools.partial(board, time=_BOARD_TIME), fields=_FIELDS
    ),
}
"""Shorter than R1, R2 and R5: the board in the first single support and two strides after it, and flat ground
for the time in which the conditions without control fall."""
CREDITED: Final = dict(zip(ABLATION_TASKS, ("torso", "torso", "leg_admittance"), strict=True))
"""Switch that the thesis' claim credits, by task."""


def ablation_conditions(switch: str, shipped: Switches) -> dict[str, SwitchCondition]:
    """All conditions of a task.

    Args:
        switch: That the thesis' claim credits.
        shipped: Of the gait.
    """
    out, alone, thesis = each_out(shipped), each_alone(), NAMED["thesis"]
    return {
        SHIPPED: out[SHIPPED],
        THESIS: SwitchCondition(thesis),
        f"the thesis' without {switch}": SwitchCondition(_with(thesis, switch, _off(switch)), THESIS),
        NONE: alone[NONE],
        "torso by the thesis' design": SwitchCondition(_with(shipped, "torso", "thesis"), SHIPPED),
        **out,
        **alone,
    }


def _ablate(context: Context) -> Results:
    return _walk_all(
        context,
        ABLATION_TASKS,
        {
            (task, name): each
            for task, of in ABLATION_TASKS.items()
            for name, each in ablation_conditions(CREDITED[task], shipped_switches(context, of.gait)).items()
        },
    )


def _decisive(cells: Sequence[Cell], task: str) -> tuple[str, ...]:
    """Conditions one switch from the shipped one whose interval lies below its."""
    of = {cell.condition: cell for cell in cells if cell.task == task}
    if SHIPPED not in of:
        return ()
    least = of[SHIPPED].result.interval[0]
    return tuple(name for name, c in of.items() if c.compared == SHIPPED and c.result.interval[1] < least)


def _ablation_quantities(measured: Measured[Results]) -> dict[str, Any]:
    cells = _cells(measured.results)
    return {"cells": cells, "decisive": {task: _decisive(cells, task) for task in ABLATION_TASKS}}


def _ablation_table(cells: Sequence[Cell], task: str) -> ReportTable:
    def falls(cell: Cell) -> str:
        times = cell.result.fall_times
        return f"{times[0]:.1f} to {times[-1]:.1f}" if times else "none"

    return table(
        f"{task}, {ABLATION_TASKS[task].duration:g} s",
        [cell for cell in cells if cell.task == task],
        {
            "condition": "{0.condition}",
            "walk on": "{0.result.survived} of {0.result.n}",
            "95 % interval": lambda cell: percent(cell.result.interval),
            "falls, s": falls,
            "torso tilt, deg, median": "{0.result.tilt_max_deg[0]:.1f}",
        },
    )


ABLATION: Final = Experiment(
    title="Each mechanism of the stabiliser alone, and each taken out",
    source="As R1, R2 and R5: which mechanism holds the walk. The thesis has no such table.",
    setup=(
        *((name, f"{task.duration:g} s") for name, task in ABLATION_TASKS.items()),
        ("board", f"{1e3 * HEIGHT:g} mm under the right foot at {_BOARD_TIME:g} s"),
    ),
    measure=_ablate,
    quantities=_ablation_quantities,
    tables=lambda measured: [_ablation_table(measured.figures["cells"], task) for task in ABLATION_TASKS],
    findings=lambda measured: [
        f"{task}: conditions whose interval lies below that of the shipped one, one switch apart: "
        f"{', '.join(names) or 'none'}."
        for task, names in measured.figures["decisive"].items()
    ],
)

# feedback: one gait

PUSHED_SPEED: Final = 0.15
"""m/s of walks that are pushed."""
PUSH: Final = 1.5
"""N s, in 0.1 s; direction and phase of the stride are drawn from the seed."""
STANDING_PUSH: Final = 2.3
"""N s, likewise, of a robot that stands."""
BEFORE: Final = 2.0
"""s of walk or stand before a push."""
AFTER: Final = 6.0
DURATION: Final = 8.0
"""s of walks over grounds, and of the straight walk."""
AHEAD: Final = (0.25, 0.0, 0.0)
"""m/s, m/s, rad/s of the straight walk."""
STRAIGHT: Final = "straight"


def _push(walk: Walk) -> dict[str, Any]:
    random = np.random.default_rng([walk.config.seed, 3])
    direction, phase = random.uniform((0.0, 0.0), (math.tau, 1.0)).tolist()
    push = StridePush(
        time=BEFORE,
        phase=None if walk.stand else phase,
        impulse=STANDING_PUSH if walk.stand else PUSH,
        direction=direction,
    )
    return {"pushes": (push,)}


def feedback_tasks(gait: str) -> dict[str, Task]:
    """Disturbed walks of a gait, and one straight ahead."""
    grounds, velocity = ground_tasks(gait, DURATION), {"velocity": (PUSHED_SPEED, 0.0, 0.0)}
    return {
        "push": Task(gait, BEFORE + AFTER, velocity, _push, _FIELDS),
        "push in a stand": Task(gait, BEFORE + AFTER, velocity, _push, _FIELDS | {"stand": True}),
        **{name: grounds[name] for name in ("plates", "slope", "worn")},
        STRAIGHT: Task(gait, DURATION, {"velocity": AHEAD}),
    }


def _gait(context: Context) -> str:
    return context.gait or "omni"


def _take_feedback(context: Context) -> Results:
    tasks, conditions = feedback_tasks(_gait(context)), each_out(shipped_switches(context, _gait(context)))
    planned = {(task, name): each for task in tasks for name, each in conditions.items()}
    results = _walk_all(context, tasks, planned, "feedback, ")
    if len(results) < len(planned):
        raise Interrupted
    return results


def _feedback_quantities(measured: Measured[Results]) -> dict[str, Any]:
    ahead = {name: found for (task, name), (_, found) in measured.results.items() if task == STRAIGHT}
    return {
        "gait": _gait(measured.context),
        "cells": _cells(measured.results),
        "speed": {name: cell(AHEAD, found, (1.0, 1.0, 1.0)).ratio for name, found in ahead.items()},
        "straight": {name: straight(found) for name, found in ahead.items()},
    }


def _feedback_table(measured: Measured[Results]) -> list[ReportTable]:
    """Walks of each condition that stood, and in brackets those that stood with it only and without it only."""
    figures = measured.figures
    cells = {(each.task, each.condition): each for each in figures["cells"]}

    def stood(name: str, task: str) -> str:
        each = cells[task, name]
        text, pair = f"{each.result.survived} of {each.result.n}", each.against_shipped
        return text if name == SHIPPED else f"{text} ({pair.only_with} / {pair.only_without})"

    columns: dict[str, Column] = {"condition": "{0}"}
    columns |= {task: functools.partial(stood, task=task) for task in dict.fromkeys(task for task, _ in cells)}
    columns["straight: measured over commanded"] = lambda name: figures["speed"][name].words(digits=2)
    columns["change of heading, deg"] = lambda name: figures["straight"][name].heading_deg.words(digits=1)
    return [table("Walks that stood (with this condition only / as shipped only)", figures["speed"], columns)]


FEEDBACK: Final = Experiment(
    title=lambda measured: f"Each feedback of the gait {_gait(measured.context)} switched off in turn",
    source="No such table has been published for a NAO.",
    setup=(
        (
            "walks",
            f"push: {PUSH:g} N s at {PUSHED_SPEED:g} m/s, {STANDING_PUSH:g} N s in a stand, any direction and "
            f"phase; plates, slope and worn as in `terrain`, {DURATION:g} s; straight: {AHEAD[0]:g} m/s, "
            f"{DURATION:g} s",
        ),
        ("switch", "the one that is named"),
    ),
    measure=_take_feedback,
    quantities=_feedback_quantities,
    tables=_feedback_table,
)
