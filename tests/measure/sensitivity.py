"""Influence of the unknowns of the robot: Morris' screening of all, Sobol' indices of the few that matter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from scipy.stats import qmc

from bridge.body import Body, load_body
from bridge.types import Array
from emulator.wear import WearProfile
from emulator.wear.ensemble import profile_of, unknowns
from nao_hil.analysis.report.render import ReportTable
from nao_hil.experiments import servo_bench
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Experiment
from nao_hil.experiments.obstacle import board, landing_force
from nao_hil.experiments.servo_bench import LEGS, STEP, motion_times
from nao_hil.experiments.torso_control import drift_per_step
from nao_hil.experiments.torso_step import BOUNDS, torso_figures
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.walk import Walk, WalkOutcome

LEVELS: Final = 4
"""Of Morris' grid: values at 0, 1/3, 2/3 and 1 of each range."""
JUMP: Final = LEVELS / (2.0 * (LEVELS - 1.0))
"""Step of an elementary effect, as a share of the range: two levels."""
LARGEST_ZERO: Final = 30.0
"""rad/s; a zero beyond is as good as none."""
KNEE: Final = "LKneePitch"
RESAMPLED: Final = 500
"""Bootstrap samples of the indices' intervals."""
CONDITIONS: Final = ("none", "thesis", "robust")
"""Torso controls of R5."""
WALK_FIGURES: Final = (
    "plate_force_N",
    "stands_plate_s",
    "drift_deg_per_step",
    "stands_static_s",
    *(f"stands_{condition}_s" for condition in CONDITIONS),
    "speed_ratio",
)
"""Landing force on the board of R1 and how long that walk stands; pitch error per step in R2 and how long that
walk stands; how long each condition of R5 stands; way over commanded."""
FIGURES: Final = (*BOUNDS, "drive_s", *WALK_FIGURES)
"""Of the torso step; request to 63 % of a knee's step; of the walks."""
DECIDES: Final = 0.5
"""An unknown decides a figure when its effect is at least that part of the largest one."""


STATIC_DURATION: Final = 30.0
"""Of the walks of R1 and R2, s."""
DYNAMIC_DURATION: Final = 10.0
"""Of the walks of R5, s."""
SPEED: Final = 0.2
"""Commanded to the gait omni, m/s."""
SPEED_DURATION: Final = 10.0
"""s"""
FEW: Final = 3
"""Unknowns that Sobol' indices are computed of."""
POINTS_PER_SEED: Final = 4
"""Base points of the Sobol' indices, rounded up to a power of two."""


class Effect(msgspec.Struct, frozen=True, kw_only=True):
    """Of one unknown on one figure, over its whole range, in the figure's unit."""

    mean: float
    """Of the absolute elementary effects (mu*)."""
    spread: float
    """Standard deviation of the elementary effects (sigma): interaction, curvature and noise."""


class Index(msgspec.Struct, frozen=True, kw_only=True):
    """Share of a figure's variance, 95 % bootstrap interval of the total."""

    first: float
    total: float
    interval: tuple[float, float]


class SensitivityTask(NamedTuple):
    """A robot whose torso step and knee are measured, for a worker."""

    body: Body
    wear: WearProfile
    seed: int
    engine: str


def measure(task: SensitivityTask) -> tuple[float, ...]:
    """The figures that need no walk; NaN where the stance fell."""
    figures = torso_figures(task.body, task.wear, task.engine, task.seed)
    table = figures or dict.fromkeys(BOUNDS, math.nan)
    table["zero_rad_s"] = min(table["zero_rad_s"], LARGEST_ZERO) if figures else math.nan
    track = servo_bench.step_response(task.body, task.wear, task.engine, KNEE, STEP)
    return *table.values(), sum(motion_times(task.body, track, LEGS.index(KNEE), STEP))


def trajectory(k: int, random: np.random.Generator) -> Array:
    """One of Morris' trajectories: each unknown changes once, in random order.

    Args:
        k: Unknowns.
        random: Generator.

    Returns:
        Shares of the ranges, shape (k + 1, k).
    """
    start = random.integers(0, LEVELS, k) / (LEVELS - 1.0)
    points = [start]
    for i in random.permutation(k):
        point = points[-1].copy()
        point[i] += JUMP if point[i] < 0.5 else -JUMP
        points.append(point)
    return np.array(points)


def elementary_effects(points: Array, figures: Array) -> Array:
    """Effects over whole ranges, shape (k, m), of a trajectory (k + 1, k) and its figures (k + 1, m)."""
    moves = np.diff(points, axis=0)
    changed = np.abs(moves).argmax(axis=1)
    effects = np.empty((points.shape[1], figures.shape[1]))
    effects[changed] = np.diff(figures, axis=0) / moves[np.arange(len(moves)), changed][:, None]
    return effects


def sensitivity(context: Context) -> dict[str, Any]:
    """Both parts."""
    names = tuple(unknowns())
    paths = [trajectory(len(names), np.random.default_rng(seed)) for seed in context.seeds]
    robots = [dict(zip(names, point, strict=True)) for path in paths for point in path.tolist()]
    seeds = [seed for seed, path in zip(context.seeds, paths, strict=True) for _ in path]
    figures = _figures(context, robots, seeds).reshape(len(paths), len(names) + 1, len(FIGURES))
    effects = np.array([elementary_effects(p, f) for p, f in zip(paths, figures, strict=True)])
    strength, spread = np.nanmean(np.abs(effects), axis=0), np.nanstd(effects, axis=0)
    relative = strength / np.maximum(np.nanmax(strength, axis=0), 1e-12)
    order = np.argsort(-np.nanmax(relative, axis=1) - 1e-3 * np.nansum(relative, axis=1))
    few = [names[i] for i in np.argsort(-np.nansum(relative, axis=1))[:FEW]]
    points = 2 ** math.ceil(math.log2(POINTS_PER_SEED * len(context.seeds)))
    try:
        indices = _indices(context, few, points)
    except Interrupted:  # the screening stands without them
        indices, points = {}, 0
    effects_of = {
        figure: {
            name: Effect(mean=float(strength[i, j]), spread=float(spread[i, j])) for i, name in enumerate(names)
        }
        for j, figure in enumerate(FIGURES)
    }
    decide = {
        figure: [names[i] for i in np.argsort(-relative[:, j]) if relative[i, j] >= DECIDES]
        for j, figure in enumerate(FIGURES)
    }
    return {
        "trajectories": len(paths),
        "robots": len(robots) + points * (len(few) + 2),  # computed, of both parts
        "effects": effects_of,  # by figure and unknown
        "decide": decide,  # by figure: unknowns of at least half the largest effect, the strongest first
        "points": points,  # base points of the indices
        "indices": indices,  # by figure and unknown; without figures that are constant or missing somewhere
        "order": [names[i] for i in order],  # unknowns, those first that matter to some figure
    }


def _figures(context: Context, robots: Sequence[dict[str, float]], seeds: Sequence[int]) -> Array:
    """Figures of robots given by shares of ranges, shape (robots, figures); walks are kept, the bench is not.

    Raises:
        Interrupted: stopped.
    """
    body = load_body(context.robot)
    wears = [
        profile_of({name: unknowns()[name].at(share) for name, share in robot.items()}, f"robot {i}", body)
        for i, robot in enumerate(robots)
    ]
    walks = [_walks(context, wear, seed) for wear, seed in zip(wears, seeds, strict=True)]
    benches = [
        SensitivityTask(body, wear, seed, context.engine) for wear, seed in zip(wears, seeds, strict=True)
    ]
    measured = context.map("sensitivity, bench", measure, benches, whole=True)
    walked = context.walk_all([walk for each in walks for walk in each])
    number = len(walks[0])
    return np.array(
        [(*bench, *_walk_figures(walked[number * i : number * (i + 1)])) for i, bench in enumerate(measured)]
    )


def _walks(context: Context, wear: WearProfile, seed: int) -> list[Walk]:
    """Of one robot: R1 as shipped, R2 without torso control, the conditions of R5, and `omni` ahead."""
    one, untracked = replace(context, seeds=(seed,)), {"wear": wear, "keep_track": False}
    static = Task("static", STATIC_DURATION, fields={"wear": wear})
    torso = "controller.switches.torso"
    return [
        *static._replace(by_seed=board).walks(one, "sensitivity, R1"),
        *static.walks(one, "sensitivity, R2", {torso: "none"}),
        *(
            walk
            for condition in CONDITIONS
            for walk in Task("dynamic", DYNAMIC_DURATION, fields=untracked).walks(
                one, f"sensitivity, {condition}", {torso: condition}
            )
        ),
        *Task("omni", SPEED_DURATION, {"velocity": (SPEED, 0.0, 0.0)}, fields=untracked).walks(
            one, "sensitivity, omni"
        ),
    ]


def _walk_figures(outcomes: Sequence[WalkOutcome]) -> tuple[float, ...]:
    """Those of `WALK_FIGURES` of one robot's `_walks`; NaN where the walk ended before."""
    on_plate, drifting, *of_conditions, ahead = outcomes
    force = landing_force(on_plate)
    drift = drift_per_step(drifting)
    return (
        math.nan if force is None else force,
        on_plate.end.time,
        math.nan if drift is None else drift,
        drifting.end.time,
        *(outcome.end.time for outcome in of_conditions),
        ahead.end.distance / (SPEED * SPEED_DURATION),
    )


def _indices(context: Context, few: Sequence[str], points: int) -> dict[str, dict[str, Index]]:
    """Sobol' indices by figure and unknown; all robots have the first seed."""
    k, seed = len(few), context.seeds[0]
    both = qmc.Sobol(2 * k, seed=seed).random(points)
    one, other = both[:, :k], both[:, k:]
    mixed = [np.where(np.arange(k) == i, other, one) for i in range(k)]
    shares = np.concatenate([one, other, *mixed]).tolist()
    robots = [dict(zip(few, row, strict=True)) for row in shares]
    figures = _figures(context, robots, [seed] * len(robots)).reshape(k + 2, points, len(FIGURES))
    resampled = np.random.default_rng(seed).integers(0, points, (RESAMPLED, points))
    found = {}
    for j, figure in enumerate(FIGURES):
        values = figures[:, :, j]
        if np.isfinite(values).all() and np.ptp(values) > 0.0:
            first, total = sobol_indices(values)
            totals = [sobol_indices(values[:, rows])[1] for rows in resampled]
            low, high = np.nanpercentile(totals, (2.5, 97.5), axis=0).tolist()
            found[figure] = {
                name: Index(first=float(first[i]), total=float(total[i]), interval=(low[i], high[i]))
                for i, name in enumerate(few)
            }
    return found


def sobol_indices(values: Array) -> tuple[Array, Array]:
    """First-order indices by Saltelli's estimator and total ones by Jansen's, each of shape (k,).

    Args:
        values: Of a figure on two independent samples, then on the first one with one unknown after the other
            taken from the second, shape (k + 2, n).

    Returns:
        NaN where the figure is constant.
    """
    one, other, *mixed = values - values[:2].mean()
    variance = float(values[:2].var())
    if variance == 0.0:
        return np.full(len(mixed), np.nan), np.full(len(mixed), np.nan)
    first = np.array([np.mean(other * (each - one)) for each in mixed]) / variance
    total = np.array([np.mean((one - each) ** 2) for each in mixed]) / (2.0 * variance)
    return first, total


def _effects_table(
    effects: dict[str, dict[str, Effect]], decide: dict[str, list[str]], order: Sequence[str]
) -> ReportTable:
    """An unknown a row, those first that matter to some figure; a star where it decides."""

    def cell(figure: str, name: str) -> str:
        return f"{effects[figure][name].mean:.3g}{' *' if name in decide[figure] else ''}"

    rows = tuple((name, *(cell(figure, name) for figure in FIGURES)) for name in order)
    return ReportTable("Mean absolute effect of the whole range (Morris)", ("unknown", *FIGURES), rows)


def _index_table(indices: dict[str, dict[str, Index]], points: int) -> ReportTable:
    rows = tuple(
        (figure, name, f"{index.first:.2f}", "{:.2f} ({:.2f} to {:.2f})".format(index.total, *index.interval))
        for figure, of in indices.items()
        for name, index in of.items()
    )
    head = ("figure", "unknown", "first order", "total (95 % interval)")
    return ReportTable(f"Sobol' indices, {points} base points", head, rows)


SENSITIVITY: Final = Experiment(
    title="Influence of the unknowns",
    source="Morris 1991; Sobol' 2001 and Saltelli 2010. Ranges: emulator/wear/unknowns.toml.",
    setup=(
        ("unknowns", "of the nominal profile; its own values where not varied"),
        ("R1", f"static gait, {STATIC_DURATION:g} s, a board of 1 cm"),
        ("R2", f"static gait, {STATIC_DURATION:g} s, torso control none"),
        ("R5", f"dynamic gait, {DYNAMIC_DURATION:g} s, torso control {', '.join(CONDITIONS)}"),
        ("speed", f"omni, {SPEED:g} m/s for {SPEED_DURATION:g} s"),
    ),
    measure=sensitivity,
    quantities=lambda measured: measured.results,
    tables=lambda measured: [
        _effects_table(*(measured.figures[key] for key in ("effects", "decide", "order"))),
        _index_table(*(measured.figures[key] for key in ("indices", "points"))),
    ],
    findings=lambda measured: [
        f"{figure}: {', '.join(who)}." for figure, who in measured.figures["decide"].items()
    ],
)
