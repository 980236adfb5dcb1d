"""Which mechanism holds the walk: each alone, and each taken out, on shortened forms of R1, R2 and R5."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import msgspec

from nao_hil.analysis.report.render import Outcome, ReportTable
from nao_hil.analysis.statistics import percent
from nao_hil.experiments.conditions import Condition, condition
from nao_hil.experiments.context import Context, Plates
from nao_hil.experiments.obstacle import HEIGHT, board
from nao_hil.runs.walk import Walk
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


@dataclass(frozen=True)
class AblationTask:
    """Walk that every condition makes."""

    name: str
    gait: str
    switch: str
    """That the thesis' claim credits."""
    suspects: tuple[str, ...]
    """Switches that are taken out first, after it."""
    duration: float
    """s"""
    plate_time: float | None = None
    """s of the walk at which the board of R1 is put under the right foot; None: none."""

    def plates(self, seed: int) -> Plates:
        """Of a seed."""
        return () if self.plate_time is None else board(seed, self.plate_time)


TASKS: Final = (
    AblationTask("R5: dynamic gait", "dynamic", "torso", ("gyroscope_damping",), duration=15.0),
    AblationTask(
        "R2: static gait", "static", "torso", ("swing_foot_orientation", "ground_tilt"), duration=30.0
    ),
    AblationTask(
        "R1: static gait, board",
        "static",
        "leg_admittance",
        ("swing_foot_orientation", "ground_tilt"),
        duration=18.0,
        plate_time=3.0,
    ),
)
"""Shorter than R1, R2 and R5: the board in the first single support and two strides after it, and flat ground
for the time in which the conditions without control fall."""


class AblationCondition(NamedTuple):
    """One choice of switches."""

    name: str
    switches: Switches
    stage: int
    """The lower, the sooner it is walked: a stop leaves the conditions that decide most."""
    compared: str = ""
    """Condition that differs in one switch, to be read against; empty: none."""


def conditions(task: AblationTask, shipped: Switches) -> list[AblationCondition]:
    """All conditions of a task.

    Args:
        task: Its claim decides the order of the walks.
        shipped: Switches of its gait.
    """
    thesis, none = NAMED["thesis"], NAMED["none"]
    found = [
        AblationCondition(SHIPPED, shipped, 0),
        AblationCondition(THESIS, thesis, 0),
        AblationCondition(
            f"the thesis' without {task.switch}", _with(thesis, task.switch, _off(task.switch)), 1, THESIS
        ),
        AblationCondition(NONE, none, 0),
        AblationCondition("torso by the thesis' design", _with(shipped, "torso", "thesis"), 1, SHIPPED),
    ]
    for name in Switches.__struct_fields__:
        if getattr(shipped, name) != _off(name):
            out = _with(shipped, name, _off(name))
            stage = 0 if name == task.switch else 1 if name in task.suspects else 2
            found.append(AblationCondition(f"without {name}", out, stage, SHIPPED))
    for name in (name for name in Switches.__struct_fields__ if name not in DEPENDENT):
        for value in ("thesis", "robust") if name == "torso" else (True,):
            title = f"torso = {value} alone" if name == "torso" else f"{name} alone"
            found.append(AblationCondition(title, _with(none, name, value), 3, NONE))
    return found


def _off(name: str) -> Any:
    return getattr(NAMED["none"], name)


def _with(switches: Switches, name: str, value: Any) -> Switches:
    return msgspec.structs.replace(switches, **{name: value})


class AblationCell(msgspec.Struct, frozen=True, kw_only=True):
    """One condition of one task."""

    task: str
    condition: str
    switches: Switches
    compared: str
    """Condition that differs in one switch; empty: none."""
    result: Condition


def experiment(context: Context) -> Outcome:
    """All conditions of all tasks, those that decide most first."""
    planned = [(task, each) for task in TASKS for each in conditions(task, _shipped(context, task.gait))]
    walks = [
        _walk(context, task, each, seed)
        for stage in sorted({each.stage for _, each in planned})
        for task in TASKS
        for seed in context.seeds
        for of, each in planned
        if of == task and each.stage == stage
    ]
    done = context.walk_by_name(walks)
    cells = [
        AblationCell(
            task=task.name,
            condition=each.name,
            switches=each.switches,
            compared=each.compared,
            result=condition(done[name]),
        )
        for task, each in planned
        if (name := _name(task, each)) in done
    ]
    decisive = {task.name: _decisive(cells, task) for task in TASKS}
    return context.outcome(
        "ablation",
        f"Each mechanism of the stabiliser alone, and each taken out ({_runs(cells)} runs a condition)",
        "As R1, R2 and R5: which mechanism holds the walk. The thesis has no such table.",
        setup=[(task.name, _words(task)) for task in TASKS],
        tables=[_table(cells, task) for task in TASKS],
        findings=[
            f"{task}: conditions whose interval lies below that of the shipped one, one switch apart: "
            f"{', '.join(names) or 'none'}."
            for task, names in decisive.items()
        ],
        figures={"cells": cells, "decisive": decisive},
    )


def _shipped(context: Context, gait: str) -> Switches:
    return controller_parameters(gait, context.config(gait, 0, {}).controller).switches


def _walk(context: Context, task: AblationTask, each: AblationCondition, seed: int) -> Walk:
    return Walk(
        name=_name(task, each),
        config=context.config(task.gait, seed, msgspec.to_builtins(each.switches)),
        duration=task.duration,
        world_events=task.plates(seed),
        keep_track=False,
    )


def _name(task: AblationTask, each: AblationCondition) -> str:
    return f"{task.name}, {each.name}"


def _decisive(cells: Sequence[AblationCell], task: AblationTask) -> tuple[str, ...]:
    of = {cell.condition: cell for cell in cells if cell.task == task.name}
    if SHIPPED not in of:
        return ()
    least = of[SHIPPED].result.interval[0]
    return tuple(
        name for name, cell in of.items() if cell.compared == SHIPPED and cell.result.interval[1] < least
    )


def _runs(cells: Sequence[AblationCell]) -> str:
    numbers = {cell.result.n for cell in cells}
    return str(min(numbers)) if len(numbers) == 1 else f"{min(numbers)} to {max(numbers)}"


def _words(task: AblationTask) -> str:
    plate = ""
    if task.plate_time is not None:
        plate = f"; at {task.plate_time:g} s a board of {1e3 * HEIGHT:g} mm under the right foot"
    return f"{task.duration:g} s{plate}"


def _table(cells: Sequence[AblationCell], task: AblationTask) -> ReportTable:
    rows = tuple(
        (
            cell.condition,
            f"{cell.result.survived} of {cell.result.n}",
            percent(cell.result.interval),
            f"{falls[0]:.1f} to {falls[-1]:.1f}" if (falls := cell.result.fall_times) else "none",
            f"{cell.result.tilt_max_deg[0]:.1f}",
        )
        for cell in cells
        if cell.task == task.name
    )
    head = ("condition", "walk on", "95 % interval", "falls, s", "torso tilt, deg, median")
    return ReportTable(f"{task.name}, {task.duration:g} s", head, rows)
