"""R5: the dynamic gait under the thesis' own controllers, torso control on and off (4.2.3, figure 4.16)."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

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
    pair_words,
    pairs,
    survives_claim,
)
from nao_hil.experiments.context import Context
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.torso_drift import MOST_FALL
from nao_hil.experiments.torso_drift import SWITCHES as SWITCHES


@dataclass(frozen=True)
class DynamicTorsoSetup:
    """The experiment's numbers."""

    duration: float = 60.0
    """s"""
    speed: float = 0.15
    """Least speed over ground, m/s; the thesis' mean, start-up included."""
    figure: float = 12.0
    """Part of the walk that the figure shows, s."""


class DynamicTorsoResult(msgspec.Struct, frozen=True, kw_only=True):
    """Survival of both conditions."""

    name: str = "dynamic-torso"
    passed: bool
    with_: Arm = msgspec.field(name="with")
    """The thesis' controllers, torso control included."""
    without: Arm
    thesis: Arm
    """The same as `with`."""
    paired: Paired
    falls_in_pitch: int
    """Falls forward or backward without torso control."""


def experiment(context: Context, setup: DynamicTorsoSetup | None = None) -> Outcome:
    """Both conditions, figure 4.16, and the verdict."""
    setup = setup or DynamicTorsoSetup()
    with_, without = context.run_switches("dynamic-torso", "dynamic", setup.duration, SWITCHES)
    arms = arm(with_), arm(without)
    in_pitch = sum(direction(r.end) in ("forward", "backward") for r in without if not r.end.survived)
    claims = torso_claims(setup, *arms)
    result = DynamicTorsoResult(
        passed=all(claim.holds for claim in claims),
        with_=arms[0],
        without=arms[1],
        thesis=arms[0],
        paired=pairs(with_, without),
        falls_in_pitch=in_pitch,
    )
    body = load_body(context.robot)
    shown = [walk[0].track.until(setup.figure) for walk in (with_, without)]
    page = ReportPage(
        name="dynamic-torso",
        title="R5: the dynamic gait under the thesis' own controllers, torso control on and off",
        source=(
            "Thesis 4.2.3, figure 4.16: the dynamic gait falls after about 4 s without torso control and "
            "goes on stably with it."
        ),
        setup=setup_rows(
            context,
            [
                ("gait", "dynamic; leg and ankle admittance, torso control of the thesis or none"),
                ("length", f"{setup.duration:g} s"),
            ],
        ),
        claims=claims,
        pictures=(
            Picture(
                axes.pitch_and_roll(context.out / "dynamic-torso-4.16.png", shown[0], shown[1], phases=True),
                "Figure 4.16: pitch of the torso, and its roll",
                f"Seed {with_[0].seed}; blue without, red with torso control; phases black: 0 DSL, 0.05 SSL, "
                "0.10 DSR, 0.15 SSR.",
            ),
        ),
        tables=(arms_table({"with torso control": arms[0], "without": arms[1]}),),
        findings=tuple(
            text
            for text in (
                pair_words(result.paired),
                falls_finding("With torso control", with_, body),
                falls_finding("Without", without, body),
            )
            if text
        ),
    )
    return Outcome(result, page)


def torso_claims(setup: DynamicTorsoSetup, with_: Arm, without: Arm) -> tuple[Claim, ...]:
    """The verdicts on both conditions."""
    return (
        falls_claim(f"Without torso control most fall within {setup.duration:g} s", without, MOST_FALL),
        survives_claim(f"With it most walk for {setup.duration:g} s", with_, MOST_FALL),
        Claim(
            f"With it at {setup.speed:g} m/s or more over ground",
            f"{with_.speed:.3f} m/s (median)",
            with_.speed >= setup.speed,
        ),
    )
