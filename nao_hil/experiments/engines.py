"""The same robot on both physics engines: torso step, drives, walks, R1, R2, R5 and getting up in one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np

from bridge.body import load_body
from bridge.types import Array
from emulator.engine.catalogue import ENGINES, require_engine
from emulator.wear import load_wear
from nao_hil.analysis.report.render import Claim, Outcome, ReportTable
from nao_hil.analysis.statistics import Estimate, Share, few_words, mean_of, median_of, share_of
from nao_hil.experiments import obstacle, torso_control
from nao_hil.experiments.context import Context, Plates
from nao_hil.experiments.get_up import WITHIN, dropped_courses
from nao_hil.experiments.servo_bench import ServoRow, bench_tracks, measure
from nao_hil.experiments.torso_responses import Responses, fit_plant, read_shape, run_task
from nao_hil.experiments.torso_step import AMPLITUDE, torso_step_tasks

DIFFERENCES: Final = (
    "Differences of the engines: the contact model (PyBullet carries a sole by four points of the "
    "outline, which it chooses, and four of a pad, with an error of the stiffness against tilting of up to "
    "40 %; MuJoCo by eight and one in the middle; all else is rigid on PyBullet and a stiff constraint on "
    "MuJoCo), the friction cone (a pyramid against an ellipse), the solver (sequential impulses, 50 sweeps at "
    "most, against Newton to convergence), and the rotors (on PyBullet in the link's tensor, where they resist "
    "a turn of the whole limb too and lower the natural frequency of the torso step by 6 to 7 %; on MuJoCo an "
    "armature of the joint)."
)
"""For people who see two numbers that differ."""
DRIVES: Final = {
    "no_load_speed": "no-load speed, rad/s",
    "request_to_motion": "time from request to motion, s",
    "backlash": "backlash, rad",
    "stall_torque": "stall torque, N m",
}
"""Fields of `ServoRow` that are compared, in words."""


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """A figure on both engines."""

    figure: str
    """In words, with its unit."""
    pybullet: Estimate | Share
    mujoco: Estimate | Share
    ratio: Estimate | None = None
    """Of MuJoCo's to PyBullet's, seed by seed; None: not compared so, or no seed has both."""
    goal: str = ""
    """Required agreement; empty: none."""
    agree: bool | None = None
    """Verdict; None: nothing is required."""


def paired_row(
    figure: str, pybullet: Mapping[int, float], mujoco: Mapping[int, float], within: float | None = None
) -> Row:
    """Means over the seeds that have the figure on both engines.

    Args:
        figure: In words.
        pybullet: By seed.
        mujoco: Likewise.
        within: Fraction by which the ratio of the engines may differ from 1, by the bounds of its interval;
            None: nothing is asked.
    """
    both = [seed for seed in pybullet if seed in mujoco]
    ratio = mean_of([mujoco[seed] / pybullet[seed] for seed in both])
    agree = None
    if within is not None:
        agree = ratio.within(1.0 - within, 1.0 + within)
    return Row(
        figure=figure,
        pybullet=mean_of([pybullet[seed] for seed in both]),
        mujoco=mean_of([mujoco[seed] for seed in both]),
        ratio=ratio if both else None,
        goal="" if within is None else f"within {100.0 * within:g} %",
        agree=agree,
    )


def count_row(figure: str, pybullet: Sequence[bool], mujoco: Sequence[bool]) -> Row:
    """Successful runs on each engine; the intervals of both shares are to overlap."""
    one, other = share_of(pybullet), share_of(mujoco)
    return Row(
        figure=figure,
        pybullet=one,
        mujoco=other,
        goal="intervals overlap",
        agree=one.interval[0] <= other.interval[1] and other.interval[0] <= one.interval[1],
    )


def row_claims(rows: Sequence[Row]) -> tuple[Claim, ...]:
    """A claim for each row of which something is asked."""
    return tuple(
        Claim(f"{row.figure} ({row.goal})", _measured(row), bool(row.agree)) for row in rows if row.goal
    )


def rows_table(rows: Sequence[Row]) -> ReportTable:
    """All rows for people."""
    verdicts = {True: "yes", False: "no", None: ""}
    return ReportTable(
        "Both engines; 95 % intervals in brackets",
        ("figure", "PyBullet", "MuJoCo", "MuJoCo / PyBullet", "goal", "agree"),
        tuple(
            (
                row.figure,
                row.pybullet.words(),
                row.mujoco.words(),
                "" if row.ratio is None else row.ratio.words(),
                row.goal,
                verdicts[row.agree],
            )
            for row in rows
        ),
    )


def _measured(row: Row) -> str:
    words = f"{row.pybullet.words()} on PyBullet, {row.mujoco.words()} on MuJoCo"
    return words if row.ratio is None else f"{words}, ratio {row.ratio.words()}"


@dataclass(frozen=True)
class EnginesSetup:
    """The experiment's numbers."""

    walks: tuple[tuple[str, float], ...] = (
        ("static", 20.0),
        ("dynamic", 15.0),
        ("huang", 15.0),
        ("omni", 10.0),
    )
    """Gaits, and how long each is walked, s; with the gait's own velocity."""
    drift: float = 60.0
    """Length of R2's walks, s: the time in which its claim has the robot fall; the experiment's last longer."""
    dynamic: float = 30.0
    """Length of R5's walks, s: half of the experiment's."""
    frequency: float = 0.05
    """Fraction by which the natural frequencies may differ."""
    speed: float = 0.10
    """Fraction by which walking speeds may differ."""


class ComparedWalk(NamedTuple):
    """A walk that both engines walk with every seed."""

    name: str
    gait: str
    duration: float
    """s"""
    switches: dict[str, Any] | None = None
    """None: as shipped."""
    plates: Callable[[int], Plates] | None = None
    """By seed."""
    speed: bool = False
    """Speeds are compared as well as survival."""


def compared_walks(setup: EnginesSetup) -> tuple[ComparedWalk, ...]:
    """The gaits by themselves, and the conditions of R1, R2 and R5."""
    gaits = [
        ComparedWalk(f"{gait} gait, {seconds:g} s", gait, seconds, speed=True) for gait, seconds in setup.walks
    ]
    r1 = [
        ComparedWalk(
            f"R1, {condition} leg admittance, {obstacle.DURATION:g} s",
            "static",
            obstacle.DURATION,
            switches,
            obstacle.board,
        )
        for condition, switches in obstacle.SWITCHES.items()
    ]
    r2 = [
        ComparedWalk(f"R2, {condition} torso control, {setup.drift:g} s", "static", setup.drift, switches)
        for condition, switches in torso_control.SWITCHES.items()
    ]
    r5 = [
        ComparedWalk(f"R5, torso control {condition}, {setup.dynamic:g} s", "dynamic", setup.dynamic, switches)
        for condition, switches in torso_control.SWITCHES.items()
    ]
    return (*gaits, *r1, *r2, *r5)


def torso_rows(context: Context, within: float) -> list[Row]:
    """Natural frequency and peak of the torso step, each seed fitted by itself."""
    body = load_body(context.robot)
    found = []
    for engine in ENGINES:
        tasks = torso_step_tasks(context.seeds, body, context.wear, AMPLITUDE, engine)
        runs: list[Responses | None] = context.map("torso-step", run_task, tasks, whole=True)
        found.append(
            {
                task.seed: _fit(run.fused.mean(axis=0), body.cycle)
                for task, run in zip(tasks, runs, strict=True)
                if run is not None
            }
        )
    (frequency, peak), (frequency_other, peak_other) = (
        [{seed: fit[i] for seed, fit in fits.items()} for i in range(2)] for fits in found
    )
    return [
        paired_row("torso step: natural frequency, rad/s", frequency, frequency_other, within),
        paired_row("torso step: peak over final value", peak, peak_other),
    ]


def drive_rows(context: Context) -> list[Row]:
    """Each quantity of the leg drives for the joint in which the engines differ most."""
    tables = context.map(
        "drives", _measure, [(context.robot, context.wear, engine) for engine in ENGINES], whole=True
    )
    joints = list(zip(*tables, strict=True))
    rows = []
    for quantity, words in DRIVES.items():
        pairs = {pair[0].joint: [float(getattr(row, quantity)) for row in pair] for pair in joints}
        worst = max(pairs, key=lambda joint: abs(pairs[joint][1] - pairs[joint][0]) / (pairs[joint][0] or 1.0))
        pybullet, mujoco = (mean_of([value]) for value in pairs[worst])
        rows.append(
            Row(figure=f"leg drives: {words}, of {worst}, which differs most", pybullet=pybullet, mujoco=mujoco)
        )
    return rows


def walk_rows(context: Context, compared: ComparedWalk, within: float) -> list[Row]:
    """Who walks on, and the speed of those that do so on both engines."""
    results = context.run(
        *(
            context.on_engine(engine).walks(
                f"{compared.name}, {engine}",
                compared.gait,
                compared.duration,
                compared.switches,
                plates=compared.plates,
                keep_track=False,
            )
            for engine in ENGINES
        )
    )
    pybullet, mujoco = ([result.end.survived for result in of] for of in results)
    rows = [count_row(f"{compared.name}: walk on", pybullet, mujoco)]
    if compared.speed:
        one, other = ({r.seed: r.end.speed for r in of if r.end.survived} for of in results)
        rows.append(paired_row(f"{compared.name}: speed over ground, m/s", one, other, within))
    return rows


def get_up_rows(context: Context) -> list[Row]:
    """Robots that stand after a drop, and their times by lying side."""
    pybullet, mujoco = (
        [course.drop for course in dropped_courses(context.on_engine(engine))] for engine in ENGINES
    )
    stand = [[drop.stands for drop in drops] for drops in (pybullet, mujoco)]
    rows = [count_row(f"get-up after a limp drop: stand within {WITHIN:g} s", stand[0], stand[1])]
    for side in ("back", "front"):
        one, other = (
            median_of([drop.time for drop in drops if drop.stands and drop.began == side])
            for drops in (pybullet, mujoco)
        )
        rows.append(Row(figure=f"get-up from the {side}: median time, s", pybullet=one, mujoco=other))
    return rows


def experiment(context: Context, setup: EnginesSetup | None = None) -> Outcome:
    """Everything on both engines with the same seeds, in one table.

    Raises:
        ConfigurationError: an engine is not installed.
    """
    setup = setup or EnginesSetup()
    for engine in ENGINES:
        require_engine(engine)
    rows = (
        *torso_rows(context, setup.frequency),
        *drive_rows(context),
        *(row for walk in compared_walks(setup) for row in walk_rows(context, walk, setup.speed)),
        *get_up_rows(context),
    )
    return context.outcome(
        "engines",
        f"PyBullet and MuJoCo: the same robot{few_words(len(context.seeds))}",
        "No part of the thesis: a claim that holds on two engines does not hang on one contact model.",
        setup=_setup_words(setup),
        claims=row_claims(rows),
        tables=[rows_table(rows)],
        findings=[DIFFERENCES],
        figures={"rows": rows},
    )


def _setup_words(setup: EnginesSetup) -> list[tuple[str, str]]:
    return [
        ("walks", ", ".join(f"{gait} {seconds:g} s" for gait, seconds in setup.walks)),
        ("R1", f"conditions of `obstacle` with its board, {obstacle.DURATION:g} s"),
        (
            "R2",
            f"conditions of `torso-drift`, {setup.drift:g} s in place of {torso_control.DURATION:g} s",
        ),
        (
            "R5",
            f"conditions of `dynamic-torso`, {setup.dynamic:g} s in place of {torso_control.DURATION:g} s",
        ),
        ("get-up", "drops of `get-up`"),
        ("means", "over the seeds that have the figure on both engines; ratios seed by seed"),
    ]


def _fit(response: Array, cycle: float) -> tuple[float, float]:
    """Natural frequency, rad/s, and peak of a step response."""
    time = np.asarray(cycle * np.arange(1.0, len(response) + 1.0), dtype=np.float64)
    return fit_plant(time, response)[0].natural_frequency_rad_s, read_shape(time, response).peak


def _measure(task: tuple[str, str, str]) -> list[ServoRow]:
    """The leg drives of a robot and wear on an engine, for a worker."""
    robot, wear, engine = task
    body = load_body(robot)
    profile = load_wear(wear, body)
    return measure(body, profile, bench_tracks(body, profile, engine))
