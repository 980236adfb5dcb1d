"""The same robot on both physics engines: torso step, drives, walks, R1, R2, R5 and getting up in one table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import msgspec

from bridge.body import load_body
from emulator.engine.catalogue import ENGINES, require_engine
from emulator.wear import load_wear
from nao_hil.analysis.report.render import Claim, Columns, table
from nao_hil.analysis.statistics import Estimate, Share, mean_of, median_of, share_of
from nao_hil.experiments import obstacle, torso_control
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Experiment
from nao_hil.experiments.get_up import WITHIN, dropped_courses
from nao_hil.experiments.servo_bench import Drive, measure_drives
from nao_hil.experiments.torso_responses import Responses, fit_plant, read_shape, run_once
from nao_hil.experiments.torso_step import AMPLITUDE, response_time, torso_step_tasks

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
"""Fields of `Drive` that are compared, in words."""


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """A figure on both engines."""

    figure: str
    """In words, with its unit."""
    pybullet: Estimate | Share
    mujoco: Estimate | Share
    ratio: Estimate | None = None
    """Ratio of MuJoCo's to PyBullet's, seed by seed; None: not compared so, or no seed has both."""
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


def row_claims(rows: Sequence[Row]) -> list[Claim]:
    """A claim for each row of which something is asked."""
    claims = []
    for row in rows:
        words = f"{row.pybullet.words()} on PyBullet, {row.mujoco.words()} on MuJoCo"
        if row.ratio is not None:
            words += f", ratio {row.ratio.words()}"
        if row.goal:
            claims.append(Claim(f"{row.figure} ({row.goal})", words, bool(row.agree)))
    return claims


COLUMNS: Final[Columns] = {
    "figure": "{0.figure}",
    "PyBullet": lambda row: row.pybullet.words(),
    "MuJoCo": lambda row: row.mujoco.words(),
    "MuJoCo / PyBullet": lambda row: "" if row.ratio is None else row.ratio.words(),
    "goal": "{0.goal}",
    "agree": lambda row: {True: "yes", False: "no", None: ""}[row.agree],
}
GAITS: Final = {"static": 20.0, "dynamic": 15.0, "huang": 15.0, "omni": 10.0}
"""Length of each gait's walk, s; with the gait's own velocity."""
DRIFT: Final = 60.0
"""Length of R2's walks, s: the time in which its claim has the robot fall."""
DYNAMIC: Final = 30.0
"""Length of R5's walks, s: half of the experiment's."""
FREQUENCY: Final = 0.05
"""Fraction by which the natural frequencies may differ."""
SPEED: Final = 0.10
"""Fraction by which walking speeds may differ."""


class ComparedWalk(NamedTuple):
    """A walk that both engines walk with every seed."""

    name: str
    task: Task
    changes: Mapping[str, Any] = {}
    """Those of the condition."""
    speed: bool = False
    """Speeds are compared as well as survival."""


def compared_walks() -> tuple[ComparedWalk, ...]:
    """The gaits by themselves, and the conditions of R1, R2 and R5."""
    gaits = (
        ComparedWalk(f"{gait} gait, {seconds:g} s", Task(gait, seconds), speed=True)
        for gait, seconds in GAITS.items()
    )
    on_board = Task("static", obstacle.DURATION, by_seed=obstacle.board)
    conditions = (
        *((f"R1, {name} leg admittance", on_board, on) for name, on in obstacle.SWITCHES.items()),
        *(
            (f"R2, {name} torso control", Task("static", DRIFT), on)
            for name, on in torso_control.SWITCHES.items()
        ),
        *(
            (f"R5, torso control {name}", Task("dynamic", DYNAMIC), on)
            for name, on in torso_control.SWITCHES.items()
        ),
    )
    return *gaits, *(ComparedWalk(f"{name}, {task.duration:g} s", task, on) for name, task, on in conditions)


def torso_rows(context: Context) -> list[Row]:
    """Natural frequency and peak of the torso step, each seed fitted by itself."""
    body, frequency, peak = context.body, [], []
    for engine in ENGINES:
        tasks = torso_step_tasks(context.on(engine=engine), AMPLITUDE)
        runs: list[Responses | None] = context.map("torso-step", run_once, tasks, whole=True)
        figures = {
            task.seed: run.fused.mean(axis=0) for task, run in zip(tasks, runs, strict=True) if run is not None
        }
        time = {seed: response_time(body, response) for seed, response in figures.items()}
        fits = {seed: fit_plant(time[seed], response)[0] for seed, response in figures.items()}
        frequency.append({seed: plant.natural_frequency_rad_s for seed, plant in fits.items()})
        peak.append({seed: read_shape(time[seed], response).peak for seed, response in figures.items()})
    return [
        paired_row("torso step: natural frequency, rad/s", frequency[0], frequency[1], FREQUENCY),
        paired_row("torso step: peak over final value", peak[0], peak[1]),
    ]


def _measure_drives(task: tuple[str, str, str]) -> list[Drive]:
    """The leg drives of a robot and wear on an engine, for a worker."""
    robot, wear, engine = task
    body = load_body(robot)
    return measure_drives(body, load_wear(wear, body), engine)


def drive_rows(context: Context) -> list[Row]:
    """Each quantity of the leg drives for the joint in which the engines differ most."""
    tasks = [(context.robot, context.wear, engine) for engine in ENGINES]
    joints = list(zip(*context.map("drives", _measure_drives, tasks, whole=True), strict=True))
    rows = []
    for quantity, words in DRIVES.items():
        pairs = {pair[0].joint: [float(getattr(row, quantity)) for row in pair] for pair in joints}
        worst = max(pairs, key=lambda joint: abs(pairs[joint][1] - pairs[joint][0]) / (pairs[joint][0] or 1.0))
        pybullet, mujoco = (mean_of([value]) for value in pairs[worst])
        rows.append(
            Row(figure=f"leg drives: {words}, of {worst}, which differs most", pybullet=pybullet, mujoco=mujoco)
        )
    return rows


def walk_rows(context: Context, compared: ComparedWalk) -> list[Row]:
    """Who walks on, and the speed of those that do so on both engines."""
    task = compared.task._replace(fields={"keep_track": False})
    walks = {e: task.walks(context.on(engine=e), f"{compared.name}, {e}", compared.changes) for e in ENGINES}
    results = context.run(walks).values()
    pybullet, mujoco = ([result.end.survived for result in of] for of in results)
    rows = [count_row(f"{compared.name}: walk on", pybullet, mujoco)]
    if compared.speed:
        one, other = ({r.seed: r.end.speed for r in of if r.end.survived} for of in results)
        rows.append(paired_row(f"{compared.name}: speed over ground, m/s", one, other, SPEED))
    return rows


def get_up_rows(context: Context) -> list[Row]:
    """Robots that stand after a drop, and their times by lying side."""
    drops = [[course.drop for course in dropped_courses(context.on(engine=engine))] for engine in ENGINES]
    stand = ([drop.stands for drop in of] for of in drops)
    rows = [count_row(f"get-up after a limp drop: stand within {WITHIN:g} s", *stand)]
    for side in ("back", "front"):
        one, other = (
            median_of([drop.time for drop in of if drop.stands and drop.began == side]) for of in drops
        )
        rows.append(Row(figure=f"get-up from the {side}: median time, s", pybullet=one, mujoco=other))
    return rows


def measure(context: Context) -> tuple[Row, ...]:
    """Everything on both engines with the same seeds, in one table.

    Raises:
        ConfigurationError: an engine is not installed.
    """
    for engine in ENGINES:
        require_engine(engine)
    return (
        *torso_rows(context),
        *drive_rows(context),
        *(row for walk in compared_walks() for row in walk_rows(context, walk)),
        *get_up_rows(context),
    )


ENGINES_COMPARED: Final = Experiment(
    title="PyBullet and MuJoCo: the same robot",
    source="No part of the thesis: a claim that holds on two engines does not hang on one contact model.",
    setup=(
        ("walks", ", ".join(f"{gait} {seconds:g} s" for gait, seconds in GAITS.items())),
        ("R1", f"conditions of `obstacle` with its board, {obstacle.DURATION:g} s"),
        ("R2", f"conditions of `torso-drift`, {DRIFT:g} s in place of {torso_control.DURATION:g} s"),
        ("R5", f"conditions of `dynamic-torso`, {DYNAMIC:g} s in place of {torso_control.DURATION:g} s"),
        ("get-up", "drops of `get-up`"),
        ("means", "over the seeds that have the figure on both engines; ratios seed by seed"),
    ),
    measure=measure,
    quantities=lambda measured: {"rows": measured.results},
    claims=lambda measured: row_claims(measured.results),
    tables=lambda measured: [table("Both engines; 95 % intervals in brackets", measured.results, COLUMNS)],
    findings=lambda _: [DIFFERENCES],
)
