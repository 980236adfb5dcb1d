"""R2: the static gait without and with torso control, all else as shipped (thesis 4.2, figure 4.9)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import load_body
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage
from nao_hil.analysis.statistics import Paired
from nao_hil.experiments import axes
from nao_hil.experiments.arms import (
    Arm,
    arm,
    arms_table,
    direction,
    falls_claim,
    falls_finding,
    growth_per_step,
    pair_words,
    pairs,
    survives_claim,
)
from nao_hil.experiments.context import Context
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.thesis_arms import ThesisArms, thesis_arms
from nao_hil.runs.walk import WalkOutcome

SWITCHES: Final[dict[str, dict[str, Any]]] = {"with": {"torso": "robust"}, "without": {"torso": "none"}}
"""By arm; they differ in one."""


@dataclass(frozen=True)
class TorsoDriftSetup:
    """The experiment's numbers."""

    duration: float = 120.0
    """s"""
    falls_by: float = 60.0
    """s by which the arm without torso control is to have fallen."""
    falls: float = 0.8
    survives: float = 0.8
    tilt: float = math.radians(4.0)
    """Largest angle of the torso against the vertical with torso control, rad."""
    probe_wear: tuple[str, ...] = ("ideal",)
    """Other states of wear that are tried when a claim about the arm with torso control fails."""
    probe_seeds: int = 2
    probe_duration: float = 60.0


class DriftResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "torso-drift"
    passed: bool
    with_: Arm = msgspec.field(name="with")
    without: Arm
    paired: Paired
    thesis: ThesisArms
    growth_with_deg: float
    """Median over the runs: slope of the mean true pitch of a step against the number of the step, up to a
    second before any fall, deg per step."""
    growth_without_deg: float
    tilt_max_deg: float
    """Largest over all runs with torso control, before any fall."""
    pitch_max_deg: float
    """The same of the pitch alone."""
    roll_max_deg: float


def experiment(context: Context, setup: TorsoDriftSetup | None = None) -> Outcome:
    """Both arms, figure 4.9, and the verdict."""
    setup = setup or TorsoDriftSetup()
    with_, without = context.run_switches("torso-drift", "static", setup.duration, SWITCHES)
    thesis = thesis_arms(context, "torso-drift", "static", setup.falls_by, SWITCHES["without"])
    arms = arm(with_), arm(without, by=setup.falls_by)
    growth = _growth(with_), _growth(without)
    pitch, roll = (_largest(with_, name) for name in ("pitch", "roll"))
    pair = pairs(with_, without)
    claims = _claims(setup, arms, growth, (pitch, roll))
    body = load_body(context.robot)
    findings = [
        thesis.words("without its torso control"),
        pair_words(pair),
        falls_finding("With torso control", with_, body),
        falls_finding("Without", without, body),
        _drift_finding(without, growth[1], setup),
        _tilt_finding(claims, with_, setup, (pitch, roll)),
    ]
    if not (claims[2].holds and claims[3].holds) and not context.campaign.interrupted:
        findings += [_probe(context, setup, wear) for wear in setup.probe_wear if wear != context.wear]
    result = DriftResult(
        passed=all(claim.holds for claim in claims),
        with_=arms[0],
        without=arms[1],
        paired=pair,
        thesis=thesis,
        growth_with_deg=growth[0],
        growth_without_deg=growth[1],
        tilt_max_deg=arms[0].tilt_max_deg[1],
        pitch_max_deg=pitch,
        roll_max_deg=roll,
    )
    return Outcome(result, _page(context, setup, result, claims, (with_[0], without[0]), findings))


def _page(
    context: Context,
    setup: TorsoDriftSetup,
    result: DriftResult,
    claims: tuple[Claim, ...],
    pictured: tuple[WalkOutcome, WalkOutcome],
    findings: Sequence[str],
) -> ReportPage:
    """The report; figure 4.9 shows a walk with torso control and one without."""
    return ReportPage(
        name="torso-drift",
        title="R2: the static gait with torso control on and off, all else as shipped",
        source=(
            "Thesis 4.2, figure 4.9: in the static gait with admittance the pitch error grows with every "
            "step until the robot falls after about 20 s; with torso control the torso is righted in every "
            "single support."
        ),
        setup=setup_rows(
            context,
            [
                ("gait", "static"),
                (
                    "arms",
                    "torso control `robust` and `none`; the thesis' configuration with its own and `none`",
                ),
                (
                    "length",
                    f"{setup.duration:g} s; without: to have fallen by {setup.falls_by:g} s",
                ),
            ],
        ),
        claims=claims,
        pictures=(
            Picture(
                axes.pitch_and_roll(
                    context.out / "torso-drift-4.9.png", pictured[0].track, pictured[1].track, phases=True
                ),
                "Figure 4.9: pitch of the torso, and its roll",
                f"Seed {pictured[0].seed}; blue without, red with torso control, cyan what it adds to the "
                "AnklePitch of the leg that stands; phases black: 0 DSL, 0.05 SSL, 0.10 DSR, 0.15 SSR.",
            ),
        ),
        tables=(
            arms_table(
                result.thesis.table("torso control off")
                | {"with torso control": result.with_, f"without, at {setup.falls_by:g} s": result.without}
            ),
        ),
        findings=tuple(text for text in findings if text),
    )


def _claims(
    setup: TorsoDriftSetup, arms: tuple[Arm, Arm], growth: tuple[float, float], largest: tuple[float, float]
) -> tuple[Claim, ...]:
    with_, without = arms
    limit = math.degrees(setup.tilt)
    return (
        Claim(
            "Without torso control the pitch error grows from step to step",
            f"{growth[1]:+.2f} deg per step without, {growth[0]:+.2f} with (medians)",
            abs(growth[1]) > abs(growth[0]) and abs(growth[1]) > 0.05,
        ),
        falls_claim(
            f"Without it {100 * setup.falls:.0f} % or more fall within {setup.falls_by:g} s",
            without,
            setup.falls,
        ),
        survives_claim(
            f"With it {100 * setup.survives:.0f} % or more walk for {setup.duration:g} s",
            with_,
            setup.survives,
        ),
        Claim(
            f"With it the torso stays within {limit:g} degrees",
            f"{with_.tilt_max_deg[0]:.1f} median, {with_.tilt_max_deg[1]:.1f} deg worst of all runs "
            f"(pitch {largest[0]:.1f}, roll {largest[1]:.1f})",
            with_.tilt_max_deg[1] <= limit,
        ),
    )


def _growth(results: Sequence[WalkOutcome]) -> float:
    """Median slope of the mean pitch per step, deg; NaN when no run has three steps."""
    slopes = [slope for result in results if (slope := drift_per_step(result)) is not None]
    return float(np.median(slopes)) if slopes else math.nan


def drift_per_step(result: WalkOutcome) -> float | None:
    """Slope of the mean true pitch of a step against its number, up to a second before a fall, deg per step.

    None: fewer than three steps.
    """
    track = result.track.until(result.end.time - (0.0 if result.end.survived else 1.0))
    return growth_per_step(track, np.degrees(track.pitch)) if len(track) else None


def _largest(results: Sequence[WalkOutcome], name: str) -> float:
    """Largest absolute pitch or roll of all runs, up to a second before any fall, deg."""
    found = [0.0]
    for result in results:
        track = result.track.until(result.end.time - (0.0 if result.end.survived else 1.0))
        found.append(float(np.abs(getattr(track, name)).max(initial=0.0)))
    return math.degrees(max(found))


def _drift_finding(without: Sequence[WalkOutcome], growth: float, setup: TorsoDriftSetup) -> str:
    """What the drift comes to over the time in which the robot should fall."""
    steps = [r.end.steps / r.end.time for r in without if r.end.time > 0.0]
    if not steps or not math.isfinite(growth):
        return ""
    total = growth * float(np.median(steps)) * setup.falls_by
    ways = [direction(r.end) for r in without if not r.end.survived]
    sideways = sum(way.startswith("to the") for way in ways)
    text = (
        f"At {growth:+.2f} deg per step the pitch error would come to {total:+.0f} deg in {setup.falls_by:g} s."
    )
    if sideways:
        text += f" {sideways} of {len(ways)} falls are sideways, which pitch control does not act on."
    return text


def _tilt_finding(
    claims: tuple[Claim, ...],
    with_: Sequence[WalkOutcome],
    setup: TorsoDriftSetup,
    largest: tuple[float, float],
) -> str:
    """When the torso leaves the bound, and in which phase; empty where it does not."""
    if claims[3].holds:
        return ""
    shares, double = [], []
    for result in with_:
        track = result.track.until(result.end.time)
        over = track.tilt > setup.tilt
        shares.append(float(over.mean()) if len(track) else 0.0)
        double.append(float((over & track.during("DSL", "DSR")).sum() / max(over.sum(), 1)))
    worst = "roll" if largest[1] > largest[0] else "pitch"
    return (
        f"The torso is beyond {math.degrees(setup.tilt):g} deg for {100 * float(np.median(shares)):.1f} % of "
        f"the time (median), {100 * float(np.median(double)):.0f} % of that in double support; the larger "
        f"part is {worst}, {max(largest) / math.degrees(setup.tilt):.1f} times the bound."
    )


def _probe(context: Context, setup: TorsoDriftSetup, wear: str) -> str:
    """The arm with torso control on a robot in another state of wear, in a sentence."""
    few = context.first(setup.probe_seeds).on(wear)
    (results,) = few.run(few.walks(f"torso-drift, with, {wear}", "static", setup.probe_duration))
    found = arm(results)
    return (
        f"On {wear} drives and sensors the same walk stands for {setup.probe_duration:g} s in "
        f"{found.survived} of {found.n} runs, the torso within {found.tilt_max_deg[1]:.1f} deg: what is "
        "beyond that comes from wear."
    )
