"""R1: a board of 1 cm under the swing foot, the bare plan and the plan with the leg admittance alone (4.1.1).

The thesis' figures 4.1, 4.2 and 4.8 come before its ankle admittance and its torso control, so neither is on
here. The right foot treads on the board for two steps and then steps down ahead of it. Both conditions walk
without a board too, so that a fall of the gait is not taken for one of the board.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np
from matplotlib.figure import Figure

from bridge.body import Body
from bridge.messages.world import PlateUnderFoot
from bridge.rotations import tilt
from nao_hil.analysis.report.render import Claim
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import (
    MAJORITY,
    Comparison,
    ankle_in_hip,
    condition,
    during,
    falls_claim,
    median_over,
    soles_in_world,
)
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Drawing, Experiment, Measured, bounded, comparison
from nao_hil.runs.run import Array, Table
from nao_hil.runs.walk import Walk, WalkOutcome
from walker.switches import NAMED

_NONE: Final[dict[str, Any]] = msgspec.to_builtins(NAMED["none"])
SWITCHES: Final[dict[str, dict[str, Any]]] = {
    "with": {"controller.switches": _NONE | {"leg_admittance": True}},
    "without": {"controller.switches": _NONE},
}
"""By condition: the leg admittance alone, and the bare plan."""
DURATION: Final = 45.0
"""s; the thesis' robot steps off its object at about 32 s."""
TIME: Final = 17.0
"""Time of the board, s of the walk: in SSL, the right foot on its way down."""
PASSED: Final = 25.0
"""s of the walk by which the thesis' robot has fallen without admittance, and with it has stepped on."""
LENGTH: Final = 0.28
"""Length of the board, m: two planned landings 12 cm apart of a sole of 15 cm, and 1 cm to spare."""
FRONT: Final = (0.143, 0.160)
"""Front edge ahead of the sole's middle at `TIME`, m. In walks with the leg admittance on the bare floor the
sole's middle at the second landing is 0.133 m ahead of it, and the heel at the third one 0.170 m: between them,
1 cm off both, the foot is borne by the board at the second landing and clears it at the third."""
HEIGHT: Final = 0.010
"""Height of the board, m."""
SIDES: Final = (-0.070, 0.045)
"""Edges to the left of the sole's middle, m: the whole sole is between them, the other foot is not."""
WITH_FORCE: Final = 5.0
"""Largest contact force in SSL in the thesis with the admittance, N."""
WITHOUT_FORCE: Final = 15.0
"""The same without it, N."""


def board(walk: Walk, time: float = TIME) -> dict[str, Any]:
    """The board as an event of a walk; its front edge is drawn from the seed, uniform in `FRONT`.

    Args:
        walk: With its seed.
        time: Of the walk, s.
    """
    front, (outer, inner) = np.random.default_rng(walk.config.seed).uniform(*FRONT), SIDES
    size, shift = (LENGTH, inner - outer, HEIGHT), (front - 0.5 * LENGTH, 0.5 * (inner + outer))
    return {"world_events": ((time, PlateUnderFoot(foot="right", size=size, shift=shift)),)}


def landing_force(result: WalkOutcome, time: float = TIME) -> float | None:
    """Largest sum of the right foot's four sensors from the board to the end of that SSL, N.

    Until the fall if that is sooner, and until the torso leans 20 degrees: the force of a falling robot is no
    landing. None: the walk ended before.
    """
    track = result.track.until(result.end.time)
    after = np.flatnonzero((track["time"] >= time) & during(track, "SSL"))
    if not after.size:
        return None
    rows = _runs(after)[0]
    rows = rows[tilt(track["world/truth.torso_orientation"])[rows] < math.radians(20.0)]
    return float(track["sensors.fsr"][rows, 4:].sum(axis=1).max()) if rows.size else None


def heights(result: WalkOutcome, body: Body, time: float = TIME) -> list[float]:
    """Mean height of the right sole's middle in each SSR after the board, before any fall, m."""
    track = result.track.until(result.end.time)
    rows = _runs(np.flatnonzero((track["time"] >= time) & during(track, "SSR")))
    middle = np.array([*body.foot.centre, 0.0, 1.0]) * (1.0, -1.0, 1.0, 1.0)
    soles = (soles_in_world(body, "R", track.where(of)) @ middle for of in rows if of.size)
    return [float(sole[:, 2].mean()) for sole in soles]


def _runs(rows: Array) -> list[Array]:
    """Row numbers split where they are not consecutive."""
    return np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)


def steps_down(found: Sequence[float]) -> bool:
    """Whether `heights` are on the board twice and then on the floor."""
    return [height > 0.5 * HEIGHT for height in found[:3]] == [True, True, False]


def obstacle(duration: float = DURATION, time: float = TIME) -> Experiment[Comparison]:
    """R1.

    Args:
        duration: Of each walk, s.
        time: Of the board, s of the walk.
    """
    titles = tuple(f"{name}, {ground}" for ground in ("board", "bare floor") for name in SWITCHES)

    def conditions(context: Context) -> dict[str, list[Walk]]:
        """Walks with and without the leg admittance, on the board and on the bare floor."""
        bare = Task("static", duration)
        tasks = {"board": bare._replace(by_seed=functools.partial(board, time=time)), "bare floor": bare}
        return {
            title: tasks[title.partition(", ")[2]].walks(
                context, f"obstacle, {title}", SWITCHES[title.partition(", ")[0]]
            )
            for title in titles
        }

    def quantities(measured: Measured[Comparison]) -> dict[str, Any]:
        """Survival on the bare floor and at 25 s, steps down from the board, and landing forces."""
        walks, body = measured.results.walks, measured.body
        with_, without = walks[titles[0]], walks[titles[1]]
        force = functools.partial(landing_force, time=time)
        return {
            "floor_with": measured.results.conditions[titles[2]],
            "floor_without": measured.results.conditions[titles[3]],
            "with_at_25_s": condition(with_, by=PASSED),
            "without_at_25_s": condition(without, by=PASSED),
            "stepped_down": sum(steps_down(heights(result, body, time)) for result in with_),
            "force_with": median_over(with_, force),  # N
            "force_without": median_over(without, force),
        }

    return comparison(
        title="R1: a board of 1 cm under the swing foot, leg admittance",
        source="Thesis 4.1.1, figures 4.1, 4.2 and 4.8: at t = 17 s, in SSL, an object of 1 cm lies under the "
        "swing foot. Without admittance the contact force reaches 15 N and the robot falls at about 18 s; "
        "with it the force stays below 5 N, the foot stays on the object for two steps and steps down at "
        "about 32 s.",
        setup=(
            ("gait", "static, T_DSP 2 s, T_SSP 1.5 s"),
            (
                "board",
                f"{1e2 * LENGTH:g} cm long, {1e3 * HEIGHT:g} mm high, at {time:g} s under the right foot",
            ),
            (
                "its front edge",
                f"{1e3 * FRONT[0]:g} to {1e3 * FRONT[1]:g} mm ahead of the sole's middle, drawn",
            ),
            ("length", f"{duration:g} s"),
            ("controllers", "the leg admittance and nothing else; without: the bare plan"),
        ),
        conditions=conditions,
        quantities=quantities,
        claims=lambda measured: _claims(measured.figures, duration),
        pictures=_pictures(time),
    )


_NOTE: Final = "Seed {seed}; blue without, red with the leg admittance."


def _pictures(time: float) -> tuple[Drawing, ...]:
    """The thesis' figures; `time` of the board, s."""
    return (
        Drawing(
            "obstacle-4.1.png",
            functools.partial(_draw_force, time=time),
            "Figure 4.1: contact force on the right foot",
            f"{_NOTE} Sum of the right foot's four sensors; phases green: 0 DSL, 5 SSL, 10 DSR, 15 SSR.",
            (9.0, 7.0),
        ),
        Drawing(
            "obstacle-4.2.png",
            lambda figure, measured: axes.pitch_and_roll(figure, *_shown(measured)),
            "Figure 4.2: pitch of the torso, and its roll",
            f"{_NOTE} True angles, positive nose down and to the right.",
            axes.TALL,
        ),
        Drawing(
            "obstacle-4.8.png",
            _draw_feet,
            "Figure 4.8: trajectories of the feet with the leg admittance",
            "Seed {seed}; ankles in the frames of their hips as requested, left solid, right dash-dotted; "
            "phases: 0 DSL, 30 SSL, 60 DSR, 90 SSR.",
        ),
    )


def _claims(found: dict[str, Any], duration: float) -> list[Claim]:
    stayed, n, forces = found["stepped_down"], found["with"].n, (found["force_with"], found["force_without"])
    return [
        falls_claim(
            f"On the board most without the admittance fall by {PASSED:g} s", found["without_at_25_s"], MAJORITY
        ),
        bounded(f"With it most stand at {PASSED:g} s", found["with_at_25_s"], MAJORITY),
        bounded(f"With it most walk on for {duration:g} s", found["with"], MAJORITY),
        Claim(
            "With it most stay on the board for two steps and step down",
            f"{stayed} of {n}",
            stayed >= MAJORITY * n,
        ),
        Claim(
            f"Contact force in SSL at most {WITH_FORCE:g} N with it, {WITHOUT_FORCE:g} N or more without",
            "{:.1f} N with, {:.1f} N without (medians of the peaks)".format(*forces),
            forces[0] <= WITH_FORCE and forces[1] >= WITHOUT_FORCE,
        ),
        *(
            bounded(f"On the bare floor most walk on {name} the admittance", found[f"floor_{name}"], MAJORITY)
            for name in SWITCHES
        ),
    ]


def _shown(measured: Measured[Comparison]) -> tuple[Table, Table]:
    with_, without, *_ = measured.results.walks.values()
    return with_[0].track, without[0].track


def _draw_force(figure: Figure, measured: Measured[Comparison], time: float) -> None:
    """Sensors of the swing foot over the time of the walk, N."""
    with_, without = _shown(measured)
    longer = with_ if with_.rows >= without.rows else without
    whole, landing = figure.subplots(2, 1)
    for panel in (whole, landing):
        axes.phase_line(panel, longer, 5.0, axes.GREEN)
        axes.two_conditions(panel, with_, without, lambda track: track["sensors.fsr"][:, 4:].sum(axis=1))
        axes.finish(panel, "t / s", "F_R,Foot,z / N")
    landing.axvline(time, color="k", linestyle=":", linewidth=0.9)
    landing.set(xlim=(time - 1.5, time + 2.5), title="about the board")


def _draw_feet(figure: Figure, measured: Measured[Comparison]) -> None:
    """Ankles in the frames of their hips as requested, over the time of the walk, mm."""
    panel, (track, _) = figure.subplots(), _shown(measured)
    ankles = (ankle_in_hip(measured.body, side, track["actuators.position"]) for side in ("L", "R"))
    axes.feet(panel, track["time"], *ankles)
    axes.phase_line(panel, track, 30.0)
    axes.finish(panel, "t / s", "p_i,0^i,8 / mm")


OBSTACLE: Final = obstacle()
