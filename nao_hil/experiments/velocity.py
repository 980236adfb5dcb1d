"""Velocity commands: measured velocity on single axes, mixed, straight ahead, changing at random."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np
from matplotlib.figure import Figure

from bridge import rotations
from bridge.errors import ConfigurationError
from bridge.planar import Pose2D
from bridge.types import Array, Vec3
from nao_hil.analysis.report.render import Claim, Columns, ReportTable, table, yes_no
from nao_hil.analysis.statistics import Estimate, Share, mean_of, share_of, wilson
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import Comparison
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Drawing, Experiment, Measured, bounded
from nao_hil.runs.run import Table
from nao_hil.runs.walk import Walk, WalkOutcome
from nao_hil.runs.walk_figures import SETTLING_TIME
from walker.gaits import gait_parameters

LEAST: Final = 1.0
"""s of walk after the settling without which nothing is measured."""


class VelocityCell(Share, frozen=True, kw_only=True):
    """Walks at one velocity."""

    command: Vec3
    """Commanded velocity, m/s, m/s, rad/s."""
    measured: Vec3
    """Medians over the walks, of the torso in its heading from 2 s on, until the end or the fall."""
    ratio: Estimate
    """Mean of measured over commanded, on the commanded axis on which it is furthest from 1."""
    coupling: Estimate
    """Largest motion on an axis that is not commanded, relative to the command; each as a part of its axis'
    full speed."""


def heading_velocity(track: Table) -> Vec3 | None:
    """Mean velocity of the torso in its own heading after the settling; None: the walk is too short."""
    time, yaw = track["time"], np.unwrap(rotations.yaw(track["world/truth.torso_orientation"]))
    late = np.flatnonzero(time >= SETTLING_TIME)
    if not len(late) or time[-1] - time[late[0]] < LEAST:
        return None
    steps, turn = np.diff(track["world/truth.torso_position"][late, :2], axis=0), np.diff(yaw[late])
    middle = yaw[late][:-1] + 0.5 * turn
    c, s = np.cos(middle), np.sin(middle)
    duration = float(time[-1] - time[late[0]])
    x = float(np.sum(c * steps[:, 0] + s * steps[:, 1])) / duration
    y = float(np.sum(c * steps[:, 1] - s * steps[:, 0])) / duration
    return x, y, float(np.sum(turn)) / duration


def cell(command: Vec3, results: Sequence[WalkOutcome], full: Vec3) -> VelocityCell:
    """Sum up the walks at one velocity.

    Args:
        command: m/s, m/s, rad/s.
        results: Of the walks, with their tracks.
        full: Speed that counts as 1 on each axis.
    """
    walked = [r.track.until(r.end.time) for r in results]
    measured = [velocity for track in walked if (velocity := heading_velocity(track)) is not None]
    alive = sum(r.end.survived for r in results)
    named = [axis for axis in range(3) if command[axis]]
    ratios = [mean_of([velocity[axis] / command[axis] for velocity in measured]) for axis in named]
    size = math.hypot(*(v / f for v, f in zip(command, full, strict=True)))
    others = [
        mean_of([abs(velocity[axis]) / full[axis] / size for velocity in measured])
        for axis in range(3)
        if axis not in named
    ]
    x, y, turn = np.median(measured, axis=0).tolist() if measured else (math.nan,) * 3
    return VelocityCell(
        command=command,
        n=len(results),
        survived=alive,
        measured=(x, y, turn),
        ratio=max(ratios, key=lambda ratio: abs(ratio.value - 1.0)),
        coupling=max(others, key=lambda coupling: coupling.value, default=mean_of([0.0, 0.0])),
    )


class Straight(msgspec.Struct, frozen=True, kw_only=True):
    """Walks straight ahead without a heading command; quantities of the survivors."""

    n: int
    survived: int
    heading_deg: Estimate
    """Absolute change of the heading."""
    odometry: Estimate
    """Error of the odometry's position, as a part of the path."""


def straight(results: Sequence[WalkOutcome]) -> Straight:
    """Sum up the walks straight ahead."""
    stood = [r.track for r in results if r.end.survived]
    return Straight(
        n=len(results),
        survived=len(stood),
        heading_deg=mean_of([abs(math.degrees(_moved(true_path(track))[2])) for track in stood]),
        odometry=mean_of([_odometry_error(track) for track in stood]),
    )


def true_path(track: Table) -> Array:
    """x, y and yaw of the torso, shape (cycles, 3), m, rad."""
    yaw = np.unwrap(rotations.yaw(track["world/truth.torso_orientation"]))
    return np.column_stack([track["world/truth.torso_position"][:, :2], yaw])


def _moved(path: Array) -> Vec3:
    """From the first pose to the last, in the frame of the first."""
    first, last = (Pose2D(*pose.tolist()) for pose in (path[0], path[-1]))
    return first.local_pose(last)


def _odometry_error(track: Table) -> float:
    """The torso sways over the middle between the feet: both ends are means over a second."""
    true, odometry = (
        _smooth(path, track["time"]) for path in (true_path(track), track["walk/telemetry.place"])
    )
    way = float(np.sum(np.hypot(*np.diff(true[::25, :2], axis=0).T)))
    return math.dist(_moved(true)[:2], _moved(odometry)[:2]) / way


def _smooth(path: Array, time: Array) -> Array:
    """Running mean over a second of a path, shape (cycles, 3)."""
    width = max(1, round(1.0 / float(np.median(np.diff(time)))))
    kernel = np.full(width, 1.0 / width)
    angles = np.unwrap(path[:, 2])
    return np.column_stack([np.convolve(each, kernel, "valid") for each in (path[:, 0], path[:, 1], angles)])


FASTEST: Final = {"nao-v6": 0.40}
"""Forward speed to reach, m/s, by body; of the others `FORWARD`."""
FORWARD: Final = 0.32
STANDS: Final = wilson(95, 100)[0]
"""A share counts as "95 of 100 stand" when the lower bound of its interval is at least that one's."""
STANDS_CHANGES: Final = wilson(47, 50)[0]
"""Lower bound of "47 of 50", likewise."""


DURATION: Final = 20.0
"""s at each velocity, and straight ahead."""
STRAIGHT: Final = 0.25
"""m/s of the walks straight ahead."""
CHANGES: Final = 30
"""Random velocities of a walk, in `CHANGES_DURATION` s; `CHANGES_SEEDS` walks at most."""
CHANGES_DURATION: Final = 120.0
CHANGES_SEEDS: Final = 50
OTHER_SEEDS: Final = 20
"""Walks at most at a command that is not the fastest of its axis: of them the ratio counts."""
RATIO: Final = (0.9, 1.1)
"""Measured over commanded, from where to where."""
COUPLING: Final = 0.1
HEADING_DEG: Final = 10.0
ODOMETRY: Final = 0.05
SIDEWAYS: Final = 0.20
"""m/s, fastest."""
TURN: Final = 1.5
"""rad/s, fastest."""


def full_speed(robot: str) -> Vec3:
    """Fastest command on each axis, m/s, m/s, rad/s."""
    return FASTEST.get(robot, FORWARD), SIDEWAYS, TURN


def fastest_commands(robot: str) -> tuple[Vec3, ...]:
    """Commands at which 95 of 100 walks are to stand."""
    ahead, aside, turn = full_speed(robot)
    return (ahead, 0.0, 0.0), (-0.25, 0.0, 0.0), (0.0, aside, 0.0), (0.0, 0.0, turn)


def commands_of(robot: str) -> tuple[Vec3, ...]:
    """Single axes, then mixtures."""
    ahead, aside, turn = full_speed(robot)
    single = (
        *((x, 0.0, 0.0) for x in (0.10, 0.20, ahead, -0.10, -0.25)),
        *((0.0, y, 0.0) for y in (0.10, aside)),
        *((0.0, 0.0, omega) for omega in (0.75, turn)),
    )
    mixed = ((0.15, 0.0, 0.6), (0.15, 0.06, 0.0), (0.0, 0.08, 0.5), (0.10, -0.05, -0.4), (-0.10, 0.0, -0.5))
    return *single, *mixed


def _gait(context: Context) -> str:
    return context.gait or "omni"


def _words(command: Vec3) -> str:
    return "{:.2f}, {:.2f} m/s, {:.2f} rad/s".format(*command)


AHEAD: Final = "velocity, straight"
RANDOM: Final = "velocity, random changes"


def _measure(context: Context) -> Comparison:
    gait, duration = _gait(context), context.duration or DURATION
    if gait_parameters(gait).limits is None:
        raise ConfigurationError(f"experiment velocity: the {gait} gait walks straight only; `omni` does not.")
    fastest, fewer = fastest_commands(context.robot), context.first(OTHER_SEEDS)
    walks = {
        f"velocity {_words(command)}": Task(gait, duration, {"velocity": command}).walks(
            context if command in fastest else fewer, f"velocity {_words(command)}"
        )
        for command in commands_of(context.robot)
    }
    walks[AHEAD] = Task(gait, DURATION, {"velocity": (STRAIGHT, 0.0, 0.0)}).walks(context, AHEAD)
    changing = Task(
        gait, CHANGES_DURATION, {"velocity": (0.1, 0.0, 0.0)}, _random_velocities, {"keep_track": False}
    )
    walks[RANDOM] = changing.walks(context.first(CHANGES_SEEDS), RANDOM)
    return Comparison(context.run(walks))


def _random_velocities(walk: Walk) -> dict[str, Any]:
    """Even in the box up to the full speeds (backward the sideways one); the gait clips them."""
    full = full_speed(walk.config.robot)
    low, random = (-full[1], -full[1], -full[2]), np.random.default_rng(walk.config.seed)
    drawn = random.uniform(low, full, (CHANGES, 3)).tolist()
    times = (CHANGES_DURATION * i / CHANGES for i in range(CHANGES))
    return {"velocities": tuple((time, (x, y, turn)) for time, (x, y, turn) in zip(times, drawn, strict=True))}


def _quantities(measured: Measured[Comparison]) -> dict[str, Any]:
    walks, robot = measured.results.walks, measured.context.robot
    return {
        "gait": _gait(measured.context),
        "cells": [
            cell(command, walks[f"velocity {_words(command)}"], full_speed(robot))
            for command in commands_of(robot)
        ],
        "straight": straight(walks[AHEAD]),
        "changes": share_of([found.end.survived for found in walks[RANDOM]]),
    }


def _claims(measured: Measured[Comparison]) -> list[Claim]:
    found, fastest = measured.figures, fastest_commands(measured.context.robot)
    cells, line, (low, high) = found["cells"], found["straight"], RATIO
    return [
        *(bounded(f"At {_words(c.command)} 95 of 100 stand", c, STANDS) for c in cells if c.command in fastest),
        *(
            bounded(
                f"At {_words(c.command)} {low:g} to {high:g} of the command is measured",
                c.ratio,
                low,
                high,
                c.ratio.words(digits=2),
            )
            for c in cells
        ),
        *(
            bounded(
                f"At {_words(c.command)} other axes move by less than {100 * COUPLING:.0f} %",
                c.coupling,
                high=COUPLING,
                words=f"{c.coupling.words(100.0, 0)} %",
            )
            for c in cells
            if not all(c.command)
        ),
        bounded(
            f"Straight at {STRAIGHT:g} m/s the heading stays within {HEADING_DEG:g} degrees",
            line.heading_deg,
            high=HEADING_DEG,
            words=f"{line.heading_deg.words(digits=1)} deg, mean of {line.survived}",
        ),
        bounded(
            f"The odometry is within {100 * ODOMETRY:g} % of the way",
            line.odometry,
            high=ODOMETRY,
            words=f"{line.odometry.words(100.0, 1)} %, mean of {line.survived}",
        ),
        bounded(
            f"{CHANGES} random velocities in {CHANGES_DURATION:g} s: 47 of 50 stand",
            found["changes"],
            STANDS_CHANGES,
        ),
    ]


def _table(measured: Measured[Comparison]) -> list[ReportTable]:
    """Commanded, measured, verdict by the bound."""
    fastest = fastest_commands(measured.context.robot)

    def reached(each: VelocityCell) -> str:
        stands = each.command not in fastest or each.interval[0] >= STANDS
        return yes_no(stands and each.ratio.within(*RATIO) and each.coupling.interval[1] < COUPLING)

    columns: Columns = {
        "commanded": lambda each: _words(each.command),
        "measured": "{0.measured[0]:.2f}, {0.measured[1]:.2f}, {0.measured[2]:.2f}",
        "ratio, worst axis": lambda each: each.ratio.words(digits=2),
        "coupling": lambda each: f"{each.coupling.words(100.0, 0)} %",
        "stand": lambda each: each.words(),
        "reached by the bound": reached,
    }
    return [table("Commanded and measured", measured.figures["cells"], columns)]


def _draw(figure: Figure, measured: Measured[Comparison]) -> None:
    cells, ahead = measured.figures["cells"], measured.results.walks[AHEAD]
    full, rows = full_speed(measured.context.robot), np.arange(len(cells))
    left, right = figure.subplots(1, 2, width_ratios=(2, 1))
    for axis, (name, colour) in enumerate((("forward", axes.BLUE), ("left", axes.GREEN), ("turn", axes.RED))):
        commanded = [each.command[axis] / full[axis] for each in cells]
        measured_parts = [each.measured[axis] / full[axis] for each in cells]
        left.scatter(commanded, rows, s=70, facecolors="none", edgecolors=colour)
        left.scatter(measured_parts, rows, s=18, color=colour, label=name)
    left.set_yticks(rows, [_words(each.command) for each in cells], fontsize=7)
    left.invert_yaxis()
    left.set(xlabel="part of full speed: commanded (rings), measured (dots)", xlim=(-1.2, 1.2))
    left.legend(fontsize=8)
    for found in ahead:
        path = true_path(found.track)
        right.plot(path[:, 0] - path[0, 0], path[:, 1] - path[0, 1], linewidth=0.5)
    right.set(xlabel="x / m", ylabel="y / m (stretched)", ylim=(-0.5, 0.5))
    right.set_title(f"{len(ahead)} walks straight ahead", fontsize=9)
    for panel in (left, right):
        panel.grid(alpha=0.3)


VELOCITY: Final = Experiment(
    title=lambda measured: f"Velocity commands, the gait {_gait(measured.context)}",
    source="Commanded and measured velocity of a NAO's walk have not been published together; limits of "
    "commands are 0.27 to 0.40 m/s forward.",
    setup=lambda measured: [
        (
            "walks",
            f"{measured.context.duration or DURATION:g} s at each velocity, from a stand; measured from 2 s on",
        ),
        ("seeds", f"{OTHER_SEEDS} at most at velocities that are not the fastest of an axis"),
        ("straight", f"{STRAIGHT:g} m/s, {DURATION:g} s, no heading command"),
        ("changes", f"{CHANGES} random velocities in {CHANGES_DURATION:g} s"),
    ],
    measure=_measure,
    quantities=_quantities,
    claims=_claims,
    tables=_table,
    pictures=(
        Drawing(
            "velocity.png",
            _draw,
            "Measured over commanded, and the ways straight ahead",
            "Left: parts of each axis' full speed. Right: ways of the torso over the ground.",
            (11.0, 5.5),
        ),
    ),
)
