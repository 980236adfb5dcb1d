"""R1: a plate of 1 cm under the swing foot in the static gait, with and without leg admittance (thesis 4.1).

The thesis' robot is brought to fall by the force with which its swing foot treads on the plate; with the
admittances the force stays small and it walks on. Two kinds of plates are drawn for each seed: one that may lie
under a part of the sole, at an angle, and one that covers the sole.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
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
from nao_hil.experiments.thesis_arms import ThesisArms, thesis_arms
from nao_hil.runs.walk import WalkOutcome

SWITCHES: Final[dict[str, dict[str, Any]]] = {
    "with": {"leg_admittance": True, "ankle_admittance": True},
    "without": {"leg_admittance": False, "ankle_admittance": True},
    "neither": {"leg_admittance": False, "ankle_admittance": False},
}
"""By arm; each arm differs in one from the one before it."""


class ObstacleResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "obstacle"
    passed: bool
    with_: Arm = msgspec.field(name="with")
    without: Arm
    """Without the leg admittance, all else as shipped."""
    neither: Arm
    """Without the ankle admittance, too."""
    thesis: ThesisArms
    covered_with: Arm
    """On a plate that covers the sole."""
    covered_without: Arm
    paired: Paired
    force_with: Force
    force_without: Force
    force_ratio: float
    """Of the medians."""
    survived_plate: float | None = None
    """Highest of the lower plates on which every run walks on with admittance, m; None: not tried, 0: none."""
    felling_plate: float | None = None
    """Lowest of the higher plates on which enough fall without it, m; None: not tried, or none of them."""


def plates(
    setup: ObstacleSetup, plate: Callable[[int, float], PlateUnderFoot] = drawn_plate
) -> Callable[[int], Plates]:
    """By seed: under the right foot, which swings in SSL."""
    return lambda seed: ((setup.plate_time, plate(seed, setup.height)),)


def experiment(context: Context, setup: ObstacleSetup | None = None) -> Outcome:
    """The arms, the figures 4.1, 4.2 and 4.8, and the verdict."""
    setup = setup or ObstacleSetup()
    laid = plates(setup)
    with_, without, neither = context.run_switches("obstacle", "static", setup.duration, SWITCHES, laid)
    thesis = thesis_arms(context, "obstacle", "static", setup.duration, SWITCHES["without"], laid)
    pair_of_arms = {name: SWITCHES[name] for name in ("with", "without")}
    on_covered, off_covered = context.run_switches(
        "obstacle, sole covered", "static", setup.duration, pair_of_arms, plates(setup, covering_plate)
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
        thesis.words("without its leg admittance"),
        f"Random plates. {pair_words(pair)}",
        f"Plates that cover the sole. {pair_words(pairs(on_covered, off_covered))}",
    ]
    body = load_body(context.robot)
    survived = felling = None
    if not context.campaign.interrupted:
        if not claims[1].holds:
            survived = _highest(context, setup)
            findings.append(
                _tried(setup.lower, setup, "with the leg admittance every run walks over", survived)
            )
        if not claims[0].holds:
            felling = _lowest(context, setup)
            findings.append(_tried(setup.higher, setup, "without it enough fall from", felling))
    findings += [
        falls_finding("With", with_, body),
        falls_finding("Without", without, body),
        falls_finding("Without both admittances", neither, body),
        _force_finding(context, forces, ratio, setup),
    ]
    result = ObstacleResult(
        passed=all(claim.holds for claim in claims),
        with_=arms[0],
        without=arms[1],
        neither=arm(neither),
        thesis=thesis,
        covered_with=arm(on_covered),
        covered_without=arm(off_covered),
        paired=pair,
        force_with=forces[0],
        force_without=forces[1],
        force_ratio=ratio,
        survived_plate=survived,
        felling_plate=felling,
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
        title="R1: plates of 1 cm under the swing foot, leg admittance on and off, all else as shipped",
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
                ("arms", "leg admittance on, off, and the ankle's off, too; the thesis' configuration"),
            ],
        ),
        claims=claims,
        pictures=_pictures(context, setup, *pictured),
        tables=(
            arms_table(
                result.thesis.table("leg admittance off")
                | {"as shipped": result.with_, "leg admittance off": result.without, "both off": result.neither}
                | {
                    "as shipped, sole covered": result.covered_with,
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
            f"{plate}: without the leg admittance {100 * setup.falls:.0f} % or more fall",
            without,
            setup.falls,
        ),
        survives_claim(f"{plate}: with it {100 * setup.survives:.0f} % or more walk on", with_, setup.survives),
    )


def _force_claim(setup: ObstacleSetup, forces: tuple[Force, Force], ratio: float) -> Claim:
    return Claim(
        "Random plate: contact force while loading in SSL at most half of that without",
        f"{forces[0].median:.1f} N with, {forces[1].median:.1f} N without (medians of the peaks): "
        f"{100.0 * ratio:.0f} %",
        ratio <= setup.force_ratio,
    )


def _share(context: Context, setup: ObstacleSetup, height: float, *, admittance: bool) -> float:
    """Share of a few runs that walks over a plate of some height, m."""
    few = context.first(setup.probe_seeds)
    arm_name = "with" if admittance else "without"
    (results,) = few.run(
        few.walks(
            f"obstacle, {arm_name}, {1e3 * height:g} mm",
            "static",
            setup.duration,
            {"leg_admittance": admittance},
            plates=plates(replace(setup, height=height)),
            keep_track=False,
        )
    )
    return arm(results).survival_ratio


def _highest(context: Context, setup: ObstacleSetup) -> float:
    """Highest lower plate on which every run walks on with admittance, those below it included, m; 0: none."""
    highest = 0.0
    for height in setup.lower:
        if _share(context, setup, height, admittance=True) < 1.0:
            break
        highest = height
    return highest


def _lowest(context: Context, setup: ObstacleSetup) -> float | None:
    """Lowest higher plate on which enough fall without admittance, m; None: on none of them."""
    for height in setup.higher:
        if _share(context, setup, height, admittance=False) <= 1.0 - setup.falls + 1e-9:
            return height
    return None


def _tried(heights: Sequence[float], setup: ObstacleSetup, what: str, found: float | None) -> str:
    tried = ", ".join(f"{1e3 * height:g}" for height in heights)
    return (
        f"Other random plates, {tried} mm with {setup.probe_seeds} seeds each: {what} "
        f"{f'{1e3 * found:g} mm' if found else 'none of them'}."
    )


def _force_finding(context: Context, forces: tuple[Force, Force], ratio: float, setup: ObstacleSetup) -> str:
    """Which damping the wanted force would take, as far as the force is damping times speed."""
    if not ratio > setup.force_ratio:
        return ""
    from walker.stabilization.parameters import controller_parameters

    changes = context.config("static", 0, {}).controller
    damping = controller_parameters("static", changes).leg.D
    wanted = setup.force_ratio * forces[1].median
    return (
        f"The leg admittance yields at F / D: for {wanted:.1f} N, half of what is measured without it, its "
        f"damping leg.D would have to be about {damping * wanted / forces[0].median:.0f} N s/m in place of "
        f"{damping:.0f}."
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
