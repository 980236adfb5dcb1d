"""Which mechanism holds the walk: each alone, and each taken out, on shortened forms of R1, R2 and R5."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from nao_hil.analysis.report.page import Outcome, ReportPage, ReportTable
from nao_hil.experiments.ablation_arms import SHIPPED, TASKS, AblationArm, AblationTask, arms
from nao_hil.experiments.arms import Arm, arm
from nao_hil.experiments.context import Context
from nao_hil.experiments.setup import setup_rows
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.parameters import controller_parameters
from walker.switches import Switches


class AblationCell(msgspec.Struct, frozen=True, kw_only=True):
    """One arm of one task."""

    task: str
    arm: str
    switches: Switches
    compared: str
    """Arm that differs in one switch; empty: none."""
    result: Arm


class AblationResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "ablation"
    passed: bool = True
    """A table claims nothing."""
    cells: tuple[AblationCell, ...]
    decisive: dict[str, tuple[str, ...]]
    """By task: arms whose interval lies below that of the shipped arm, from which they differ in one switch."""


def experiment(context: Context, tasks: Sequence[AblationTask] = TASKS) -> Outcome:
    """All arms of all tasks, those that decide most first."""
    planned = [(task, each) for task in tasks for each in arms(task, _shipped(context, task.gait))]
    walks = [
        _walk(context, task, each, seed)
        for stage in sorted({each.stage for _, each in planned})
        for task in tasks
        for seed in context.seeds
        for of, each in planned
        if of == task and each.stage == stage
    ]
    done: dict[str, list[WalkOutcome]] = {}
    for walked in context.campaign.walk(walks):
        done.setdefault(walked.walk.name, []).append(walked)
    if not done:
        raise Interrupted
    cells = tuple(
        AblationCell(
            task=task.name,
            arm=each.name,
            switches=each.switches,
            compared=each.compared,
            result=arm(done[name]),
        )
        for task, each in planned
        if (name := _name(task, each)) in done
    )
    result = AblationResult(cells=cells, decisive={task.name: _decisive(cells, task) for task in tasks})
    page = ReportPage(
        name="ablation",
        title=f"Each mechanism of the stabiliser alone, and each taken out ({_runs(cells)} runs an arm)",
        source="Beside R1, R2 and R5: which mechanism holds the walk. The thesis has no such table.",
        setup=setup_rows(context, [(task.name, _words(task)) for task in tasks]),
        claims=(),
        tables=tuple(_table(cells, task) for task in tasks),
        findings=tuple(_finding(result.decisive[task.name], task) for task in tasks),
    )
    return Outcome(result, page)


def _shipped(context: Context, gait: str) -> Switches:
    return controller_parameters(gait, context.config(gait, 0, {}).controller).switches


def _walk(context: Context, task: AblationTask, each: AblationArm, seed: int) -> Walk:
    return Walk(
        name=_name(task, each),
        config=context.config(task.gait, seed, msgspec.to_builtins(each.switches)),
        duration=task.duration,
        world_events=task.plates(seed),
        keep_track=False,
    )


def _name(task: AblationTask, each: AblationArm) -> str:
    return f"{task.name}, {each.name}"


def _decisive(cells: Sequence[AblationCell], task: AblationTask) -> tuple[str, ...]:
    of = {cell.arm: cell for cell in cells if cell.task == task.name}
    if SHIPPED not in of:
        return ()
    least = of[SHIPPED].result.interval[0]
    return tuple(
        name for name, cell in of.items() if cell.compared == SHIPPED and cell.result.interval[1] < least
    )


def _finding(decisive: Sequence[str], task: AblationTask) -> str:
    reported = ", ".join(decisive) or "none"
    return f"{task.name}: arms whose interval lies below that of the shipped one, one switch apart: {reported}."


def _runs(cells: Sequence[AblationCell]) -> str:
    numbers = {cell.result.n for cell in cells}
    return str(min(numbers)) if len(numbers) == 1 else f"{min(numbers)} to {max(numbers)}"


def _words(task: AblationTask) -> str:
    plate = ""
    if task.plate_time is not None:
        plate = (
            f"; at {task.plate_time:g} s a plate of {1e3 * task.plate_height:g} mm under the right foot; size, "
            "place and angle drawn from the seed"
        )
    return f"{task.duration:g} s{plate}"


def _table(cells: Sequence[AblationCell], task: AblationTask) -> ReportTable:
    rows = []
    for cell in cells:
        if cell.task == task.name:
            low, high = (100.0 * bound for bound in cell.result.interval)
            falls = cell.result.fall_times
            rows.append(
                (
                    cell.arm,
                    f"{cell.result.survived} of {cell.result.n}",
                    f"{low:.0f} to {high:.0f} %",
                    f"{falls[0]:.1f} to {falls[-1]:.1f}" if falls else "none",
                    f"{cell.result.tilt_max_deg[0]:.1f}",
                )
            )
    head = ("arm", "walk on", "95 % interval", "falls, s", "torso tilt, deg, median")
    return ReportTable(f"{task.name}, {task.duration:g} s", head, tuple(rows))
