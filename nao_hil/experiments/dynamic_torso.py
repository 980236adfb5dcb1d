"""R5: the dynamic gait without torso control, with the thesis' and with the robust one (figure 4.16).

All else is as shipped, damping by the gyroscope included; a fourth arm has the robust control without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import msgspec

from bridge.body import load_body
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
from nao_hil.experiments.context import Context
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.thesis_arms import ThesisArms, thesis_arms
from nao_hil.runs.walk import WalkOutcome

SWITCHES: Final[dict[str, dict[str, Any]]] = {
    "none": {"torso": "none", "gyroscope_damping": True},
    "thesis": {"torso": "thesis", "gyroscope_damping": True},
    "robust": {"torso": "robust", "gyroscope_damping": True},
    "robust, undamped": {"torso": "robust", "gyroscope_damping": False},
}
"""By arm; each arm differs in one from the one before it, the first three in torso control alone."""


@dataclass(frozen=True)
class DynamicTorsoSetup:
    """The experiment's numbers."""

    duration: float = 60.0
    """s"""
    falls_by: float = 15.0
    """s by which the arm without torso control is to have fallen."""
    falls: float = 0.8
    survives: float = 0.8
    speed: float = 0.15
    """m/s over ground, at least."""
    probe_wear: str = "worn"
    """Another robot, tried without torso control when too few fall."""
    probe_seeds: int = 4


class DynamicTorsoResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "dynamic-torso"
    passed: bool
    with_: Arm = msgspec.field(name="with")
    without: Arm
    thesis: Arm
    """With the thesis' own design in place of the robust one; no claim rests on it."""
    undamped: Arm
    """As `with`, without damping by the gyroscope."""
    thesis_alone: ThesisArms
    paired: Paired


def experiment(context: Context, setup: DynamicTorsoSetup | None = None) -> Outcome:
    """Three arms, figure 4.16, and the verdict."""
    setup = setup or DynamicTorsoSetup()
    without, thesis, with_, undamped = context.run_switches(
        "dynamic-torso", "dynamic", setup.duration, SWITCHES
    )
    alone = thesis_arms(context, "dynamic-torso", "dynamic", setup.falls_by, {"torso": "none"})
    arms = arm(with_), arm(without, by=setup.falls_by), arm(thesis), arm(undamped)
    pair = pairs(with_, without)
    claims = _claims(setup, arms[0], arms[1])
    body = load_body(context.robot)
    findings = (
        alone.words("without its torso control"),
        pair_words(pair),
        falls_finding("Without", without, body),
        falls_finding("With the thesis' design", thesis, body),
        falls_finding("With the robust design", with_, body),
        falls_finding("With the robust design, without damping", undamped, body),
        "" if claims[0].holds or context.campaign.interrupted else _probe(context, setup),
    )
    result = DynamicTorsoResult(
        passed=all(claim.holds for claim in claims),
        with_=arms[0],
        without=arms[1],
        thesis=arms[2],
        undamped=arms[3],
        thesis_alone=alone,
        paired=pair,
    )
    return Outcome(result, _page(context, setup, result, claims, (with_[0], without[0]), findings))


def _page(
    context: Context,
    setup: DynamicTorsoSetup,
    result: DynamicTorsoResult,
    claims: tuple[Claim, ...],
    pictured: tuple[WalkOutcome, WalkOutcome],
    findings: Sequence[str],
) -> ReportPage:
    """The report; figure 4.16 shows a walk with the robust torso control and one without."""
    return ReportPage(
        name="dynamic-torso",
        title="R5: the dynamic gait with three torso controls, all else as shipped",
        source=(
            "Thesis 4.2.3, figure 4.16: the dynamic gait falls after about 4 s without torso control and "
            "goes on stably with it."
        ),
        setup=setup_rows(
            context,
            [
                ("gait", "dynamic"),
                (
                    "arms",
                    "torso control `none`, `thesis`, `robust`; `robust` without damping; the thesis alone",
                ),
                ("length", f"{setup.duration:g} s; without: to have fallen by {setup.falls_by:g} s"),
            ],
        ),
        claims=claims,
        pictures=(
            Picture(
                axes.pitch_and_roll(
                    context.out / "dynamic-torso-4.16.png", pictured[0].track, pictured[1].track, phases=True
                ),
                "Figure 4.16: pitch of the torso, and its roll",
                f"Seed {pictured[0].seed}; blue without, red with the robust torso control; phases black: 0 "
                "DSL, 0.05 SSL, 0.10 DSR, 0.15 SSR.",
            ),
        ),
        tables=(
            arms_table(
                result.thesis_alone.table("torso control off")
                | {
                    f"none, at {setup.falls_by:g} s": result.without,
                    "thesis": result.thesis,
                    "robust": result.with_,
                    "robust, no damping": result.undamped,
                }
            ),
        ),
        findings=tuple(text for text in findings if text),
    )


def _claims(setup: DynamicTorsoSetup, with_: Arm, without: Arm) -> tuple[Claim, ...]:
    return (
        falls_claim(
            f"Without torso control {100 * setup.falls:.0f} % or more fall within {setup.falls_by:g} s",
            without,
            setup.falls,
        ),
        survives_claim(
            f"With it {100 * setup.survives:.0f} % or more walk for {setup.duration:g} s",
            with_,
            setup.survives,
        ),
        Claim(
            f"With it at {setup.speed:g} m/s or more over ground",
            f"{with_.speed:.3f} m/s (median)",
            with_.speed >= setup.speed,
        ),
    )


def _probe(context: Context, setup: DynamicTorsoSetup) -> str:
    """The arm without torso control on a robot with more backlash, in a sentence."""
    few = context.first(setup.probe_seeds).on(setup.probe_wear)
    (results,) = few.run(
        few.walks(
            f"dynamic-torso, none, {setup.probe_wear}",
            "dynamic",
            setup.falls_by,
            {"torso": "none"},
            keep_track=False,
        )
    )
    fell = arm(results).fall_words()
    return f"On {setup.probe_wear} drives, without torso control and by {setup.falls_by:g} s: {fell}."
