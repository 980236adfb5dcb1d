"""Figures of real robots, measured on the emulated one in the same way."""

from __future__ import annotations

import itertools
import math
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import load_body
from emulator.wear import load_wear, wear_of_seed
from nao_hil.analysis.report.render import Claim, Outcome, ReportTable
from nao_hil.analysis.statistics import mean_of
from nao_hil.experiments.context import Context
from nao_hil.experiments.robot_figures import FIGURES, knee_hold, noise_at_rest, standing, tracking
from nao_hil.experiments.torso_step import BOUNDS, torso_figures

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
        Interrupted: stopped.
    """
    tasks = [Task(group, context.wear, seed, context.engine) for seed in context.seeds]
    stood = [each for each in context.map(group, measure, tasks, whole=True) if each is not None]
    table = {}
    for name, figure in FIGURES.items():
        if not name.startswith(f"{group}.") or not stood or name not in stood[0]:
            continue
        mean = mean_of([each[name] for each in stood])
        table[name.partition(".")[2]] = {
            "real": figure.real,
            "measured": mean.value,
            "interval": mean.interval if mean.n != 1 else (mean.value, mean.value),
            "bounds": (figure.low, figure.high),
            "unit": figure.unit,
            "holds": figure.holds(mean.value),
        }
    return table, stood


def experiment(context: Context, *groups: str) -> Outcome:
    """Figures of some groups on one page; of all, and of the torso step, unless some are named."""
    alone = len(groups) == 1
    claims, lines = [], []
    data: dict[str, Any] = {}
    for group in groups or ROBOTS:
        table, stood = rows(context, group)
        if not table:
            claims.append(Claim(TITLES[group], "the robot fell with every seed", False))
        best = np.mean([each["best"] for each in stood], axis=0) if group == "tracking" and stood else []
        for shift, (name, row) in itertools.zip_longest(best, table.items()):
            figure = FIGURES[f"{group}.{name}"]
            if shift is not None:
                row["shift_frames"] = float(shift)
            low, high = row["interval"]
            words = f"{row['measured']:.3g} ({low:.3g} to {high:.3g}) {figure.unit}"
            claims.append(Claim(f"{figure.words}: {figure.real:g} {figure.unit}", words, row["holds"]))
            bounds = f"{figure.low:g} to {figure.high:g}"
            lines.append(
                (figure.words, figure.unit, f"{figure.real:g}", bounds, words, ROBOTS[group], figure.source)
            )
        data |= table if alone else {group: table}
    if not groups:
        claims += _torso_claims(context)
    head = ("figure", "unit", "real", "tolerance", "emulated (95 %)", "robot", "source")
    return context.outcome(
        groups[0].replace("_", "-") if alone else "real-robots",
        TITLES[groups[0]] if alone else "Real robots and the emulated one",
        "Recordings and published figures of real robots; each row names its own.",
        setup=[("robots", "the generation of each source")],
        claims=claims,
        tables=[ReportTable("Real and emulated", head, tuple(lines))],
        figures=data,
    )


def _torso_claims(context: Context) -> list[Claim]:
    body = load_body("nao-v3")
    steps = [
        torso_figures(body, load_wear(wear_of_seed(context.wear, seed), body), context.engine, seed)
        for seed in context.seeds
    ]
    means = {name: mean_of([step[name] for step in steps if step is not None]) for name in BOUNDS}
    return [
        Claim(
            f"Torso step: {bound.words}",
            mean.words(),
            bound.holds(mean.value),
        )
        for bound, mean in zip(BOUNDS.values(), means.values(), strict=True)
    ]
