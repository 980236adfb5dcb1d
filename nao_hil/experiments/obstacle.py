"""R1: a plate of 1 cm under the swing foot, the thesis' own controllers with and without leg admittance (4.1).

The thesis' robot is brought to fall by the force with which its swing foot treads on the plate; with the
admittances the force stays small and it walks on. Two kinds of plates are drawn for each seed: one that may lie
under a part of the sole, at an angle, and one that covers the sole.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

import msgspec

from bridge.body import load_body
from bridge.messages.world import PlateUnderFoot
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage
from nao_hil.analysis.statistics import Paired
from nao_hil.experiments import axes
from nao_hil.experiments.arms import (
    Arm,
    arm,
    arms_table,
    falls_claim,
    falls_finding,
    pair_words,
    pairs,
    survives_claim,
)
from nao_hil.experiments.context import Context, Plates
from nao_hil.experiments.geometry import ankle_in_hip
from nao_hil.experiments.landing_force import Force, ObstacleSetup, landing_forces, plot_feet, plot_force
from nao_hil.experiments.plates import covering_plate, drawn_plate
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.torso_drift import MOST_FALL
from nao_hil.runs.walk import WalkOutcome
from walker.switches import NAMED

_THESIS: Final[dict[str, Any]] = msgspec.to_builtins(NAMED["thesis"])
SWITCHES: Final[dict[str, dict[str, Any]]] = {
    "with": _THESIS,
    "without": _THESIS | {"leg_admittance": False},
}
"""By condition: the thesis' admittances and torso control, and the same without the leg admittance."""


class ObstacleResult(msgspec.Struct, frozen=True, kw_only=True):
    """Survival and landing forces of all conditions."""

    name: str = "obstacle"
    passed: bool
    with_: Arm = msgspec.field(name="with")
    without: Arm
    covered_with: Arm
    """On a plate that covers the sole."""
    covered_without: Arm
    paired: Paired
    force_with: Force
    force_without: Force
    force_ratio: float
    """Of the medians."""


def plates(
    setup: ObstacleSetup, plate: Callable[[int, float], PlateUnderFoot] = drawn_plate
) -> Callable[[int], Plates]:
    """By seed: under the right foot, which swings in SSL."""
    return lambda seed: ((setup.plate_time, plate(seed, setup.height)),)


def experiment(context: Context, setup: ObstacleSetup | None = None) -> Outcome:
    """The arms, the figures 4.1, 4.2 and 4.8, and the verdict."""
    setup = setup or ObstacleSetup()
    laid = plates(setup)
    with_, without = context.run_switches("obstacle", "static", setup.duration, SWITCHES, laid)
    on_covered, off_covered = context.run_switches(
        "obstacle, sole covered", "static", setup.duration, SWITCHES, plates(setup, covering_plate)
    )
    forces = landing_forces(with_, setup), landing_forces(without, setup)
    arms = arm(with_), arm(without)
    ratio = forces[0].median / forces[1].median if forces[1].median else math.nan
    pair = pairs(with_, without)
    claims = (
        *_claims(setup, "Random plate", arms),
        *_claims(setup, "Plate that covers the sole", (arm(on_covered), arm(off_covered))),
        _force_claim(setup, forces, ratio),
    )
    findings = [
        f"Random plates. {pair_words(pair)}",
        f"Plates that cover the sole. {pair_words(pairs(on_covered, off_covered))}",
    ]
    body = load_body(context.robot)
    findings += [
        falls_finding("With", with_, body),
        falls_finding("Without", without, body),
        falls_finding("With, sole covered", on_covered, body),
        falls_finding("Without, sole covered", off_covered, body),
    ]
    result = ObstacleResult(
        passed=all(claim.holds for claim in claims),
        with_=arms[0],
        without=arms[1],
        covered_with=arm(on_covered),
        covered_without=arm(off_covered),
        paired=pair,
        force_with=forces[0],
        force_without=forces[1],
        force_ratio=ratio,
    )
    return Outcome(result, _page(context, setup, result, claims, (with_[0], without[0]), findings))


def _page(
    context: Context,
    setup: ObstacleSetup,
    result: ObstacleResult,
    claims: tuple[Claim, ...],
    pictured: tuple[WalkOutcome, WalkOutcome],
    findings: Sequence[str],
) -> ReportPage:
    """The report; its figures show a walk with the leg admittance and one without."""
    return ReportPage(
        name="obstacle",
        title="R1: plates of 1 cm under the swing foot, the thesis' own controllers, leg admittance on and off",
        source=(
            "Thesis 4.1, figures 4.1, 4.2 and 4.8: at t = 17 s, in SSL, an object of 1 cm lies under the "
            "swing foot. Without admittance the contact force reaches 15 N and the robot falls at about 18 "
            "s; with it the force stays at about 5 N, the foot stays on the object for two steps and steps "
            "down at about 32 s."
        ),
        setup=setup_rows(
            context,
            [
                ("gait", "static, T_DSP 2 s, T_SSP 1.5 s"),
                (
                    "plate",
                    f"{1e3 * setup.height:g} mm, under the right foot at {setup.plate_time:g} s of the walk; "
                    "size, place and angle drawn from the seed, or edges around the sole",
                ),
                ("length", f"{setup.duration:g} s"),
                ("controllers", "the thesis' admittances and torso control; without: leg admittance off"),
            ],
        ),
        claims=claims,
        pictures=_pictures(context, setup, *pictured),
        tables=(
            arms_table(
                {
                    "leg admittance": result.with_,
                    "leg admittance off": result.without,
                    "leg admittance, sole covered": result.covered_with,
                    "leg admittance off, sole covered": result.covered_without,
                }
            ),
        ),
        findings=tuple(text for text in findings if text),
    )


def _claims(setup: ObstacleSetup, plate: str, arms: tuple[Arm, Arm]) -> tuple[Claim, ...]:
    with_, without = arms
    return (
        falls_claim(
            f"{plate}: without the leg admittance most fall",
            without,
            MOST_FALL,
        ),
        survives_claim(f"{plate}: with it most walk on", with_, MOST_FALL),
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
