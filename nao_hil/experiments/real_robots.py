"""Figures of real robots, measured on the emulated one as they were measured there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import load_body
from emulator.wear import load_wear, wear_of_seed
from nao_hil.analysis.report.page import Claim, Outcome, ReportPage, ReportTable
from nao_hil.experiments.context import Context
from nao_hil.experiments.engines_rows import mean_of
from nao_hil.experiments.robot_figures import FIGURES, knee_hold, noise_at_rest, standing, tracking
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.torso_step import BOUNDS, torso_figures
from nao_hil.runs.campaign import Interrupted

ROBOTS: Final = {
    "tracking": "nao-v6",
    "knee_hold": "nao-v5",
    "imu_noise": "nao-v6",
    "force_cells": "nao-v6",
    "currents": "nao-v3",
}
"""Body of each group of figures: the generation of its source."""
TITLES: Final = {
    "tracking": "Tracking errors of the legs in a walk",
    "knee_hold": "A knee that holds its leg out",
    "imu_noise": "Noise at rest",
    "force_cells": "Force cells of a standing robot",
    "currents": "Motor currents of a standing robot",
}


class Task(msgspec.Struct, frozen=True):
    """A measurement, for a worker."""

    group: str
    wear: str
    seed: int
    engine: str


def measure(task: Task) -> dict[str, Any] | None:
    """Figures of one group on its robot; None: the robot fell."""
    body = load_body(ROBOTS[task.group])
    wear = load_wear(wear_of_seed(task.wear, task.seed), body)
    if task.group == "tracking":
        walked = tracking(body, wear, task.seed, task.engine)
        return None if walked is None else {**walked.figures(), "best": list(walked.best.values())}
    if task.group == "knee_hold":
        return {"knee_hold.knee_pitch": math.degrees(knee_hold(body, wear, task.engine, task.seed))}
    if task.group == "imu_noise":
        return noise_at_rest(body, wear, task.seed, task.engine)
    found = standing(body, wear, task.seed, task.engine)
    return {name: value for name, value in found.items() if name.startswith(task.group)}


def rows(context: Context, group: str) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Each figure of a group with its real value, ours and the interval over the seeds.

    Raises:
        Interrupted: it was stopped.
    """
    tasks = [Task(group, context.wear, seed, context.engine) for seed in context.seeds]
    measured = context.campaign.map(group, measure, tasks)
    if len(measured) < len(tasks):
        raise Interrupted
    stood = [each for each in measured if each is not None]
    table = {}
    for name, figure in FIGURES.items():
        if not name.startswith(f"{group}.") or not stood or name not in stood[0]:
            continue
        mean = mean_of([each[name] for each in stood])
        low, high = (mean.value if bound is None else bound for bound in (mean.low, mean.high))
        table[name.partition(".")[2]] = {
            "real": figure.real,
            "measured": mean.value,
            "interval": (low, high),
            "bounds": (figure.low, figure.high),
            "unit": figure.unit,
            "holds": figure.holds(mean.value or 0.0),
        }
    return table, stood


def outcome(context: Context, groups: Sequence[str]) -> Outcome:
    """The page and the JSON of some groups."""
    tables = {group: rows(context, group) for group in groups}
    claims, lines = [], []
    data: dict[str, Any] = {}
    for group, (table, stood) in tables.items():
        best = np.mean([each["best"] for each in stood], axis=0) if group == "tracking" and stood else None
        for i, (name, row) in enumerate(table.items()):
            figure = FIGURES[f"{group}.{name}"]
            if best is not None and i < len(best):
                row["shift_frames"] = float(best[i])
            low, high = row["interval"]
            words = f"{row['measured']:.3g} ({low:.3g} to {high:.3g}) {figure.unit}"
            claims.append(Claim(f"{figure.words}: {figure.real:g} {figure.unit}", words, row["holds"]))
            lines.append(
                (
                    figure.words,
                    figure.unit,
                    f"{figure.real:g}",
                    f"{figure.low:g} to {figure.high:g}",
                    words,
                    ROBOTS[group],
                    figure.source,
                )
            )
        data |= table if len(groups) == 1 else {group: table}
    name = groups[0].replace("_", "-") if len(groups) == 1 else "real-robots"
    page = ReportPage(
        name=name,
        title=TITLES[groups[0]] if len(groups) == 1 else "Real robots and the emulated one",
        source="Recordings and published figures of real robots; each row names its own.",
        setup=setup_rows(context, [("robots", "the generation of each source")]),
        claims=tuple(claims),
        tables=(
            ReportTable(
                "Real and emulated",
                ("figure", "unit", "real", "tolerance", "emulated (95 %)", "robot", "source"),
                tuple(lines),
            ),
        ),
    )
    passed = bool(claims) and all(claim.holds for claim in claims)
    return Outcome(result_of(name, passed, data), page)


def result_of(name: str, passed: bool, figures: dict[str, Any]) -> msgspec.Struct:
    """A result whose keys are the figures' names.

    Args:
        name: Of the experiment.
        passed: Every figure is within its bounds.
        figures: By name.
    """
    fields = {"name": name, "passed": passed} | {
        k: v for k, v in figures.items() if k not in ("name", "passed")
    }
    kind = msgspec.defstruct("RealRobotResult", [(key, Any) for key in fields])
    made: msgspec.Struct = kind(**fields)
    return made


def _alone(group: str) -> Callable[[Context], Outcome]:
    return lambda context: outcome(context, [group])


tracking_experiment = _alone("tracking")
knee_hold_experiment = _alone("knee_hold")
imu_noise_experiment = _alone("imu_noise")
force_cells_experiment = _alone("force_cells")
currents_experiment = _alone("currents")


def experiment(context: Context) -> Outcome:
    """All groups in one table, the torso step beside them."""
    found = outcome(context, list(ROBOTS))
    body = load_body("nao-v3")
    steps = [
        torso_figures(body, load_wear(wear_of_seed(context.wear, seed), body), context.engine, seed)
        for seed in context.seeds
    ]
    stood = [step for step in steps if step is not None]
    claims = []
    for name, bound in BOUNDS.items():
        mean = mean_of([step[name] for step in stood])
        claims.append(
            Claim(
                f"Torso step: {bound.words}", mean.words(), mean.value is not None and bound.holds(mean.value)
            )
        )
    page = replace(found.page, claims=found.page.claims + tuple(claims))
    figures = msgspec.to_builtins(found.result)
    return Outcome(result_of("real-robots", page.passed, figures), page)
