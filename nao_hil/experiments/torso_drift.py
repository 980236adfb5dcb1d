"""R2: the static gait under the thesis' own controllers, torso control on and off (4.2, figure 4.9)."""

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
    falls_claim,
    falls_finding,
    growth_per_step,
    pair_words,
    pairs,
    survives_claim,
)
from nao_hil.experiments.context import Context
from nao_hil.experiments.setup import setup_rows
from nao_hil.runs.walk import WalkOutcome
from walker.switches import NAMED

_THESIS: Final[dict[str, Any]] = msgspec.to_builtins(NAMED["thesis"])
SWITCHES: Final[dict[str, dict[str, Any]]] = {"with": _THESIS, "without": _THESIS | {"torso": "none"}}
"""By condition: the thesis' admittances and its torso control, and the same without torso control."""
MOST_FALL: Final = 2.0 / 3.0
"""Lower bound of the share that falls, and of the share that walks on: 18 of 20 reach it, 17 do not."""


@dataclass(frozen=True)
class TorsoDriftSetup:
    """The experiment's numbers."""

    duration: float = 60.0
    """s"""
    growth_deg: float = 0.05
    """Least growth of the pitch without torso control, degrees per step."""


class DriftResult(msgspec.Struct, frozen=True, kw_only=True):
    """Survival of both conditions, and growth of the pitch."""

    name: str = "torso-drift"
    passed: bool
    with_: Arm = msgspec.field(name="with")
    without: Arm
    paired: Paired
    growth_with_deg: float
    """Median over the runs: slope of the mean true pitch of a step against the number of the step, up to a
    second before any fall, deg per step."""
    growth_without_deg: float


def experiment(context: Context, setup: TorsoDriftSetup | None = None) -> Outcome:
    """Both conditions, figure 4.9, and the verdict."""
    setup = setup or TorsoDriftSetup()
    with_, without = context.run_switches("torso-drift", "static", setup.duration, SWITCHES)
    arms = arm(with_), arm(without)
    growth = _growth(with_), _growth(without)
    claims = drift_claims(setup, arms, growth)
    result = DriftResult(
        passed=all(claim.holds for claim in claims),
        with_=arms[0],
        without=arms[1],
        paired=pairs(with_, without),
        growth_with_deg=growth[0],
        growth_without_deg=growth[1],
    )
    body = load_body(context.robot)
    page = ReportPage(
        name="torso-drift",
        title="R2: the static gait under the thesis' own controllers, torso control on and off",
        source=(
            "Thesis 4.2, figure 4.9: in the static gait with admittance the pitch error grows with every "
            "step until the robot falls after about 20 s; with torso control the torso is righted in every "
            "single support."
        ),
        setup=setup_rows(
            context,
            [
                ("gait", "static; leg and ankle admittance, torso control of the thesis or none"),
                ("length", f"{setup.duration:g} s"),
            ],
        ),
        claims=claims,
        pictures=(
            Picture(
                axes.pitch_and_roll(
                    context.out / "torso-drift-4.9.png", with_[0].track, without[0].track, phases=True
                ),
                "Figure 4.9: pitch of the torso, and its roll",
                f"Seed {with_[0].seed}; blue without, red with torso control, cyan what it adds to the "
                "AnklePitch of the leg that stands; phases black: 0 DSL, 0.05 SSL, 0.10 DSR, 0.15 SSR.",
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


def drift_claims(
    setup: TorsoDriftSetup, arms: tuple[Arm, Arm], growth: tuple[float, float]
) -> tuple[Claim, ...]:
    """The verdicts on both conditions, with torso control first."""
    with_, without = arms
    return (
        Claim(
            "Without torso control the pitch grows from step to step",
            f"{growth[1]:+.2f} deg per step without, {growth[0]:+.2f} with (medians)",
            abs(growth[1]) > max(abs(growth[0]), setup.growth_deg),
        ),
        falls_claim(f"Without it most fall within {setup.duration:g} s", without, MOST_FALL),
        survives_claim(f"With it most walk for {setup.duration:g} s", with_, MOST_FALL),
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
