"""R1: a plate of 1 cm under the swing foot, the thesis' own controllers with and without leg admittance (4.1).

The thesis' robot is brought to fall by the force with which its swing foot treads on the plate; with the
admittances the force stays small and it walks on. Two kinds of plates are drawn for each seed: one that may lie
under a part of the sole, at an angle, and one that covers the sole.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import load_body
from bridge.messages.world import PlateUnderFoot
from nao_hil.analysis.report.render import Claim, Outcome, Picture
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import (
    MAJORITY,
    Comparison,
    Condition,
    ankle_in_hip,
    conditions_table,
    falls_claim,
    falls_finding,
    pair_words,
    survives_claim,
)
from nao_hil.experiments.context import Context, Plates
from nao_hil.files import save_figure
from nao_hil.runs.track import Array, Track
from nao_hil.runs.walk import WalkOutcome
from walker.switches import NAMED

LENGTH: Final = (0.08, 0.20)
"""m"""
WIDTH: Final = (0.04, 0.10)
"""m"""
YAW: Final = math.radians(45.0)
"""Largest turn against the foot, rad."""
AHEAD: Final = (0.0, 0.06)
"""Middle of the plate ahead of the lifted sole's, m."""
OUTWARD: Final = (0.0, 0.05)
"""Middle of the plate outward of it, m."""
INWARD_REACH: Final = 0.045
"""Farthest that a plate may reach inward of the sole's middle, m: the other foot stands there."""
_TRIES: Final = 1000
COVERED_BEHIND: Final = (0.08, 0.10)
"""Rear edge of a plate that covers the sole, behind the lifted sole's middle, m."""
COVERED_AHEAD: Final = (0.16, 0.20)
"""Its front edge ahead of it, m: the sole lands a step farther."""
COVERED_OUTWARD: Final = (0.055, 0.090)
"""Its outer edge outward of it, m."""
_THESIS: Final[dict[str, Any]] = msgspec.to_builtins(NAMED["thesis"])
SWITCHES: Final[dict[str, dict[str, Any]]] = {
    "with": _THESIS,
    "without": _THESIS | {"leg_admittance": False},
}
"""By condition: the thesis' admittances and torso control, and the same without the leg admittance."""


def drawn_plate(seed: int, height: float) -> PlateUnderFoot:
    """A plate under the right foot whose size, place and angle follow from the seed; uniform draws.

    Args:
        seed: Of the walk.
        height: Of the plate, m.
    """
    draw = np.random.default_rng(seed).uniform
    for _ in range(_TRIES):
        length, width, yaw = draw(*LENGTH), draw(*WIDTH), draw(-YAW, YAW)
        ahead, outward = draw(*AHEAD), draw(*OUTWARD)
        half = 0.5 * (length * abs(math.sin(yaw)) + width * math.cos(yaw))
        if half - outward <= INWARD_REACH:
            return PlateUnderFoot(foot="right", size=(length, width, height), shift=(ahead, -outward), yaw=yaw)
    raise AssertionError("no plate fits next to the other foot")


def covering_plate(seed: int, height: float) -> PlateUnderFoot:
    """A plate that the whole right foot stands on; its edges follow from the seed, uniform draws.

    Args:
        seed: Of the walk.
        height: Of the plate, m.
    """
    draw = np.random.default_rng(seed).uniform
    behind, ahead, outward = draw(*COVERED_BEHIND), draw(*COVERED_AHEAD), draw(*COVERED_OUTWARD)
    return PlateUnderFoot(
        foot="right",
        size=(behind + ahead, INWARD_REACH + outward, height),
        shift=(0.5 * (ahead - behind), 0.5 * (INWARD_REACH - outward)),
        yaw=0.0,
    )


@dataclass(frozen=True)
class ObstacleSetup:
    """The experiment's numbers."""

    duration: float = 45.0
    """s; the thesis' robot steps off the plate at about 32 s."""
    plate_time: float = 17.0
    """s of the walk: in SSL, the swing foot on its way down."""
    height: float = 0.01
    """m"""
    force_ratio: float = 0.5
    """Largest force with over that without, at most."""


class Force(msgspec.Struct, frozen=True, kw_only=True):
    """Largest sum of the swing foot's sensors from the plate to the end of that SSL, N: over the runs."""

    median: float
    largest: float


def landing_force(result: WalkOutcome, plate_time: float) -> float | None:
    """Largest sum of the right foot's four sensors from the plate to the end of that SSL, N.

    Until the fall if that is sooner, and until the torso leans 20 degrees: the force of a falling robot is no
    landing. None: the walk ended before.
    """
    track = result.track.until(result.end.time)
    time = track["time"]
    after = np.flatnonzero((time >= plate_time) & track.during("SSL"))
    if not after.size:
        return None
    breaks = np.flatnonzero(np.diff(after) > 1)
    rows = after[: int(breaks[0]) + 1] if breaks.size else after
    rows = rows[track.tilt[rows] < math.radians(20.0)]
    return float(track["fsr"][rows, 4:].sum(axis=1).max()) if rows.size else None


def landing_forces(results: Sequence[WalkOutcome], setup: ObstacleSetup) -> Force:
    """Median and largest landing force over the runs."""
    found = [f for r in results if (f := landing_force(r, setup.plate_time)) is not None]
    if not found:
        return Force(median=math.nan, largest=math.nan)
    return Force(median=float(np.median(found)), largest=max(found))


def plot_force(path: Path, with_: Track, without: Track, plate_time: float) -> Path:
    """Sensors of the swing foot over the time of the walk, N."""
    figure = axes.new_figure(9.0, 7.0)
    longer = with_ if len(with_) >= len(without) else without
    whole, landing = figure.subplots(2, 1)
    for panel in (whole, landing):
        axes.phase_line(panel, longer, 5.0, axes.GREEN)
        axes.two_conditions(panel, with_, without, lambda track: track["fsr"][:, 4:].sum(axis=1))
        axes.finish(panel, "t / s", "F_R,Foot,z / N")
    landing.axvline(plate_time, color="k", linestyle=":", linewidth=0.9)
    landing.set(xlim=(plate_time - 1.5, plate_time + 2.5), title="about the plate")
    return save_figure(figure, path)


def plot_feet(path: Path, track: Track, left: Array, right: Array) -> Path:
    """Heights of both soles over the time of the walk, m."""
    figure = axes.new_figure()
    panel = figure.subplots()
    axes.feet(panel, track["time"], left, right)
    axes.phase_line(panel, track, 30.0)
    axes.finish(panel, "t / s", "p_i,0^i,8 / mm")
    return save_figure(figure, path)


def plates(
    setup: ObstacleSetup, plate: Callable[[int, float], PlateUnderFoot] = drawn_plate
) -> Callable[[int], Plates]:
    """By seed: under the right foot, which swings in SSL."""
    return lambda seed: ((setup.plate_time, plate(seed, setup.height)),)


def experiment(context: Context, setup: ObstacleSetup | None = None) -> Outcome:
    """The conditions, the figures 4.1, 4.2 and 4.8, and the verdict."""
    setup = setup or ObstacleSetup()
    drawn, covered = (
        Comparison(
            dict(zip(titles, context.run_switches(name, "static", setup.duration, SWITCHES, laid), strict=True))
        )
        for name, titles, laid in (
            ("obstacle", ("With", "Without"), plates(setup)),
            (
                "obstacle, sole covered",
                ("With, sole covered", "Without, sole covered"),
                plates(setup, covering_plate),
            ),
        )
    )
    with_, without = drawn.walks.values()
    forces = landing_forces(with_, setup), landing_forces(without, setup)
    ratio = forces[0].median / forces[1].median if forces[1].median else math.nan
    body, conditions = load_body(context.robot), drawn.conditions | covered.conditions
    first, second, third, fourth = conditions.values()
    return context.outcome(
        "obstacle",
        "R1: plates of 1 cm under the swing foot, the thesis' own controllers, leg admittance on and off",
        "Thesis 4.1, figures 4.1, 4.2 and 4.8: at t = 17 s, in SSL, an object of 1 cm lies under the swing "
        "foot. Without admittance the contact force reaches 15 N and the robot falls at about 18 s; with it "
        "the force stays at about 5 N, the foot stays on the object for two steps and steps down at about 32 "
        "s.",
        setup=[
            ("gait", "static, T_DSP 2 s, T_SSP 1.5 s"),
            (
                "plate",
                f"{1e3 * setup.height:g} mm, under the right foot at {setup.plate_time:g} s of the walk; "
                "size, place and angle drawn from the seed, or edges around the sole",
            ),
            ("length", f"{setup.duration:g} s"),
            ("controllers", "the thesis' admittances and torso control; without: leg admittance off"),
        ],
        claims=[
            *_claims("Random plate", (first, second)),
            *_claims("Plate that covers the sole", (third, fourth)),
            _force_claim(setup, forces, ratio),
        ],
        pictures=_pictures(context, setup, with_[0], without[0]),
        tables=[conditions_table(conditions)],
        findings=[
            "Random plates. " + pair_words(drawn.pair),
            "Plates that cover the sole. " + pair_words(covered.pair),
            *(
                falls_finding(name, results, body)
                for name, results in (*drawn.walks.items(), *covered.walks.items())
            ),
        ],
        figures={
            "with": first,
            "without": second,
            "covered_with": third,
            "covered_without": fourth,
            "paired": drawn.pair,
            "force_with": forces[0],
            "force_without": forces[1],
            "force_ratio": ratio,  # of the medians
        },
    )


def _claims(plate: str, conditions: tuple[Condition, Condition]) -> tuple[Claim, ...]:
    with_, without = conditions
    return (
        falls_claim(f"{plate}: without the leg admittance most fall", without, MAJORITY),
        survives_claim(f"{plate}: with it most walk on", with_, MAJORITY),
    )


def _force_claim(setup: ObstacleSetup, forces: tuple[Force, Force], ratio: float) -> Claim:
    return Claim(
        "Random plate: contact force while loading in SSL at most half of that without",
        f"{forces[0].median:.1f} N with, {forces[1].median:.1f} N without (medians of the peaks): "
        f"{100.0 * ratio:.0f} %",
        ratio <= setup.force_ratio,
    )


def _pictures(
    context: Context, setup: ObstacleSetup, with_: WalkOutcome, without: WalkOutcome
) -> tuple[Picture, ...]:
    seed = with_.seed
    note = f"Seed {seed}; blue without, red with the leg admittance."
    out, body = context.out, load_body(context.robot)
    return (
        Picture(
            plot_force(out / "obstacle-4.1.png", with_.track, without.track, setup.plate_time),
            "Figure 4.1: contact force on the right foot",
            f"{note} Sum of the right foot's four sensors; phases green: 0 DSL, 5 SSL, 10 DSR, 15 SSR.",
        ),
        Picture(
            axes.pitch_and_roll(out / "obstacle-4.2.png", with_.track, without.track),
            "Figure 4.2: pitch of the torso, and its roll",
            f"{note} True angles, positive nose down and to the right.",
        ),
        Picture(
            plot_feet(
                out / "obstacle-4.8.png",
                with_.track,
                ankle_in_hip(body, "L", with_.track["request"]),
                ankle_in_hip(body, "R", with_.track["request"]),
            ),
            "Figure 4.8: trajectories of the feet with the leg admittance",
            f"Seed {seed}; ankles in the frames of their hips as requested, left solid, right dash-dotted; "
            "phases: 0 DSL, 30 SSL, 60 DSR, 90 SSR.",
        ),
    )
