"""R1: a board of 1 cm under the swing foot, the bare plan and the plan with the leg admittance alone (4.1.1).

The thesis' figures 4.1, 4.2 and 4.8 come before its ankle admittance and its torso control, so neither is on
here. The right foot treads on the board for two steps and then steps down ahead of it. Both conditions walk
without a board too, so that a fall of the gait is not taken for one of the board.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import Body, load_body
from bridge.messages.world import PlateUnderFoot
from nao_hil.analysis.report.render import Claim, Outcome, Picture
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import (
    MAJORITY,
    Comparison,
    ankle_in_hip,
    condition,
    conditions_table,
    falls_claim,
    soles_in_world,
    survives_claim,
)
from nao_hil.experiments.context import Context, Plates
from nao_hil.files import save_figure
from nao_hil.runs.track import Array, Track
from nao_hil.runs.walk import WalkOutcome
from walker.switches import NAMED

_NONE: Final[dict[str, Any]] = msgspec.to_builtins(NAMED["none"])
SWITCHES: Final[dict[str, dict[str, Any]]] = {"with": _NONE | {"leg_admittance": True}, "without": _NONE}
"""By condition: the leg admittance alone, and the bare plan."""
DURATION: Final = 45.0
"""s; the thesis' robot steps off its object at about 32 s."""
TIME: Final = 17.0
"""Of the board, s of the walk: in SSL, the right foot on its way down."""
PASSED: Final = 25.0
"""s of the walk by which the thesis' robot has fallen without admittance, and with it has stepped on."""
LENGTH: Final = 0.28
"""Of the board, m: two planned landings 12 cm apart of a sole of 15 cm, and 1 cm to spare."""
FRONT: Final = (0.143, 0.160)
"""Front edge ahead of the sole's middle at `TIME`, m. In walks with the leg admittance on the bare floor the
sole's middle at the second landing is 0.133 m ahead of it, and the heel at the third one 0.170 m: between them,
1 cm off both, the foot is borne by the board at the second landing and clears it at the third."""
HEIGHT: Final = 0.010
"""m"""
SIDES: Final = (-0.070, 0.045)
"""Edges to the left of the sole's middle, m: the whole sole is between them, the other foot is not."""
WITH_FORCE: Final = 5.0
"""Largest contact force in SSL in the thesis with the admittance, N."""
WITHOUT_FORCE: Final = 15.0
"""The same without it, N."""


def board(seed: int, time: float = TIME) -> Plates:
    """The board; its front edge is drawn from the seed, uniform in `FRONT`.

    Args:
        seed: Of the walk.
        time: Of the walk, s.
    """
    front, (outer, inner) = np.random.default_rng(seed).uniform(*FRONT), SIDES
    size, shift = (LENGTH, inner - outer, HEIGHT), (front - 0.5 * LENGTH, 0.5 * (inner + outer))
    return ((time, PlateUnderFoot(foot="right", size=size, shift=shift)),)


def landing_force(result: WalkOutcome, time: float = TIME) -> float | None:
    """Largest sum of the right foot's four sensors from the board to the end of that SSL, N.

    Until the fall if that is sooner, and until the torso leans 20 degrees: the force of a falling robot is no
    landing. None: the walk ended before.
    """
    track = result.track.until(result.end.time)
    after = np.flatnonzero((track["time"] >= time) & track.during("SSL"))
    if not after.size:
        return None
    rows = _runs(after)[0]
    rows = rows[track.tilt[rows] < math.radians(20.0)]
    return float(track["fsr"][rows, 4:].sum(axis=1).max()) if rows.size else None


def heights(result: WalkOutcome, body: Body, time: float = TIME) -> list[float]:
    """Mean height of the right sole's middle in each SSR after the board, before any fall, m."""
    track = result.track.until(result.end.time)
    rows = _runs(np.flatnonzero((track["time"] >= time) & track.during("SSR")))
    middle = np.array([*body.foot.centre, 0.0, 1.0]) * (1.0, -1.0, 1.0, 1.0)
    soles = (soles_in_world(body, "R", Track(track.rows[of])) @ middle for of in rows if of.size)
    return [float(sole[:, 2].mean()) for sole in soles]


def _runs(rows: Array) -> list[Array]:
    """Row numbers split where they are not consecutive."""
    return np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)


def steps_down(found: Sequence[float]) -> bool:
    """Whether `heights` are on the board twice and then on the floor."""
    return [height > 0.5 * HEIGHT for height in found[:3]] == [True, True, False]


def plot_force(path: Path, with_: Track, without: Track, time: float) -> Path:
    """Sensors of the swing foot over the time of the walk, N."""
    figure = axes.new_figure(9.0, 7.0)
    longer = with_ if len(with_) >= len(without) else without
    whole, landing = figure.subplots(2, 1)
    for panel in (whole, landing):
        axes.phase_line(panel, longer, 5.0, axes.GREEN)
        axes.two_conditions(panel, with_, without, lambda track: track["fsr"][:, 4:].sum(axis=1))
        axes.finish(panel, "t / s", "F_R,Foot,z / N")
    landing.axvline(time, color="k", linestyle=":", linewidth=0.9)
    landing.set(xlim=(time - 1.5, time + 2.5), title="about the board")
    return save_figure(figure, path)


def plot_feet(path: Path, body: Body, track: Track) -> Path:
    """Ankles in the frames of their hips as requested, over the time of the walk, mm."""
    figure = axes.new_figure()
    panel = figure.subplots()
    axes.feet(panel, track["time"], *(ankle_in_hip(body, side, track["request"]) for side in ("L", "R")))
    axes.phase_line(panel, track, 30.0)
    axes.finish(panel, "t / s", "p_i,0^i,8 / mm")
    return save_figure(figure, path)


def experiment(context: Context, duration: float = DURATION, time: float = TIME) -> Outcome:
    """Both conditions with and without the board, the figures 4.1, 4.2 and 4.8, and the verdict."""
    body, laid = load_body(context.robot), functools.partial(board, time=time)
    titles = tuple(f"{name}, {ground}" for ground in ("board", "bare floor") for name in SWITCHES)
    walks = (
        context.walks(
            f"obstacle, {title}", "static", duration, SWITCHES[title.partition(",")[0]], plates=plates
        )
        for title, plates in zip(titles, (laid, laid, None, None), strict=True)
    )
    compared = Comparison(dict(zip(titles, context.run(*walks), strict=True)))
    with_, without, *_ = compared.walks.values()
    conditions = list(compared.conditions.values())
    forces = [
        float(np.median([f for result in of if (f := landing_force(result, time)) is not None] or [math.nan]))
        for of in (with_, without)
    ]
    stayed = [steps_down(heights(result, body, time)) for result in with_]
    passed, fallen = (condition(of, by=PASSED) for of in (with_, without))
    return context.outcome(
        "obstacle",
        "R1: a board of 1 cm under the swing foot, leg admittance",
        "Thesis 4.1.1, figures 4.1, 4.2 and 4.8: at t = 17 s, in SSL, an object of 1 cm lies under the swing "
        "foot. Without admittance the contact force reaches 15 N and the robot falls at about 18 s; with it "
        "the force stays below 5 N, the foot stays on the object for two steps and steps down at about 32 s.",
        setup=[
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
        ],
        claims=[
            falls_claim(f"On the board most without the admittance fall by {PASSED:g} s", fallen, MAJORITY),
            survives_claim(f"With it most stand at {PASSED:g} s", passed, MAJORITY),
            survives_claim(f"With it most walk on for {duration:g} s", conditions[0], MAJORITY),
            Claim(
                "With it most stay on the board for two steps and step down",
                f"{sum(stayed)} of {len(stayed)}",
                sum(stayed) >= MAJORITY * len(stayed),
            ),
            Claim(
                f"Contact force in SSL at most {WITH_FORCE:g} N with it, {WITHOUT_FORCE:g} N or more without",
                f"{forces[0]:.1f} N with, {forces[1]:.1f} N without (medians of the peaks)",
                forces[0] <= WITH_FORCE and forces[1] >= WITHOUT_FORCE,
            ),
            *(
                survives_claim(f"On the bare floor most walk on {name} the admittance", of, MAJORITY)
                for name, of in zip(SWITCHES, conditions[2:], strict=True)
            ),
        ],
        pictures=_pictures(context.out, body, with_[0], without[0], time),
        tables=[conditions_table(compared.conditions)],
        findings=compared.findings(body),
        figures={
            "with": conditions[0],
            "without": conditions[1],
            "floor_with": conditions[2],
            "floor_without": conditions[3],
            "with_at_25_s": passed,
            "stepped_down": sum(stayed),
            "paired": compared.pair,
            "force_with": forces[0],  # N, median over the runs
            "force_without": forces[1],
        },
    )


def _pictures(
    out: Path, body: Body, with_: WalkOutcome, without: WalkOutcome, time: float
) -> tuple[Picture, ...]:
    note = f"Seed {with_.seed}; blue without, red with the leg admittance."
    return (
        Picture(
            plot_force(out / "obstacle-4.1.png", with_.track, without.track, time),
            "Figure 4.1: contact force on the right foot",
            f"{note} Sum of the right foot's four sensors; phases green: 0 DSL, 5 SSL, 10 DSR, 15 SSR.",
        ),
        Picture(
            axes.pitch_and_roll(out / "obstacle-4.2.png", with_.track, without.track),
            "Figure 4.2: pitch of the torso, and its roll",
            f"{note} True angles, positive nose down and to the right.",
        ),
        Picture(
            plot_feet(out / "obstacle-4.8.png", body, with_.track),
            "Figure 4.8: trajectories of the feet with the leg admittance",
            f"Seed {with_.seed}; ankles in the frames of their hips as requested, left solid, right "
            "dash-dotted; phases: 0 DSL, 30 SSL, 60 DSR, 90 SSR.",
        ),
    )
