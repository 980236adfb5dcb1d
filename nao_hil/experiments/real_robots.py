"""Figures of real robots, measured on the emulated one in the same way."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np

from bridge.body import load_body
from emulator.wear import load_wear, wear_of_seed
from nao_hil.analysis.report.render import Claim, Columns, ReportTable, table
from nao_hil.analysis.statistics import Estimate, mean_of
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Experiment, bounded
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


class GroupTask(msgspec.Struct, frozen=True):
    """A measurement, for a worker."""

    group: str
    wear: str
    seed: int
    engine: str


def measure(task: GroupTask) -> dict[str, Any] | None:
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
    figures = standing(body, wear, task.seed, task.engine)
    return {name: value for name, value in figures.items() if name.startswith(task.group)}


def group_rows(group: str, stood: list[dict[str, Any]]) -> dict[str, Any]:
    """Each figure of a group with its real value, ours and the interval over the seeds.

    Args:
        group: Of `ROBOTS`.
        stood: Figures of each robot that did not fall.
    """
    rows: dict[str, Any] = {}
    for name, figure in FIGURES.items():
        if not name.startswith(f"{group}.") or not stood or name not in stood[0]:
            continue
        mean = mean_of([each[name] for each in stood])
        rows[name.partition(".")[2]] = {
            "real": figure.real,
            "measured": mean.value,
            "interval": mean.interval if mean.n != 1 else (mean.value, mean.value),
            "bounds": (figure.low, figure.high),
            "unit": figure.unit,
            "holds": figure.holds(mean.value),
        }
    if group == "tracking" and stood:
        best = np.mean([each["best"] for each in stood], axis=0).tolist()
        for row, shift in zip(rows.values(), best, strict=False):
            row["shift_frames"] = shift
    return rows


class RealFigures(NamedTuple):
    """Measurements of the emulated robots."""

    groups: dict[str, dict[str, Any]]
    """`group_rows` by group."""
    torso: dict[str, Estimate]
    """Means over the seeds of the figures of `BOUNDS`; empty: not measured."""


def measure_groups(context: Context, groups: Iterable[str], *, torso: bool) -> RealFigures:
    """Measure some groups, and the torso step if asked.

    Raises:
        Interrupted: stopped.
    """
    figures = {}
    for group in groups:
        tasks = [GroupTask(group, context.wear, seed, context.engine) for seed in context.seeds]
        results = context.map(group, measure, tasks, whole=True)
        figures[group] = group_rows(group, [each for each in results if each is not None])
    return RealFigures(figures, _torso_step(context) if torso else {})


def _torso_step(context: Context) -> dict[str, Estimate]:
    body = load_body("nao-v3")
    steps = [
        torso_figures(body, load_wear(wear_of_seed(context.wear, seed), body), context.engine, seed)
        for seed in context.seeds
    ]
    return {name: mean_of([step[name] for step in steps if step is not None]) for name in BOUNDS}


def _words(row: dict[str, Any]) -> str:
    words = "{measured:.3g} ({interval[0]:.3g} to {interval[1]:.3g}) {unit}".format(**row)
    return words + (f", least at {row['shift_frames']:.1f} frames" if "shift_frames" in row else "")


def _claims(found: RealFigures) -> list[Claim]:
    claims = []
    for group, rows in found.groups.items():
        if not rows:
            claims.append(Claim(TITLES[group], "the robot fell with every seed", False))
        for name, row in rows.items():
            figure = FIGURES[f"{group}.{name}"]
            claims.append(Claim(f"{figure.words}: {figure.real:g} {figure.unit}", _words(row), row["holds"]))
    for name, mean in found.torso.items():
        words, low, high = BOUNDS[name]
        claims.append(bounded(f"Torso step: {words}", mean.value, low, high, mean.words()))
    return claims


def _table(found: RealFigures) -> list[ReportTable]:
    items = [
        (FIGURES[f"{group}.{name}"], row, group)
        for group, rows in found.groups.items()
        for name, row in rows.items()
    ]
    columns: Columns = {
        "figure": "{0[0].words}",
        "unit": "{0[0].unit}",
        "real": "{0[0].real:g}",
        "tolerance": "{0[0].low:g} to {0[0].high:g}",
        "emulated (95 %)": lambda item: _words(item[1]),
        "robot": lambda item: ROBOTS[item[2]],
        "source": "{0[0].source}",
    }
    return [table("Real and emulated", items, columns)]


def _experiment(title: str, *groups: str) -> Experiment[RealFigures]:
    """Figures of one group, or of several and of the torso step."""
    alone = len(groups) == 1
    return Experiment(
        title=title,
        source="Recordings and published figures of real robots; each row names its own.",
        setup=(("robots", "the generation of each source"),),
        measure=lambda context: measure_groups(context, groups, torso=not alone),
        quantities=lambda measured: measured.results.groups[groups[0]] if alone else measured.results.groups,
        claims=lambda measured: _claims(measured.results),
        tables=lambda measured: _table(measured.results),
    )


REAL_ROBOTS: Final = _experiment("Real robots and the emulated one", *ROBOTS)
TRACKING, KNEE_HOLD, IMU_NOISE, FORCE_CELLS, CURRENTS = (_experiment(TITLES[group], group) for group in ROBOTS)
