"""R2 and R5: both gaits under the thesis' own controllers, with and without torso control (4.2; 4.9, 4.16)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np

from bridge.body import load_body
from nao_hil.analysis.report.render import Claim, Outcome, Picture
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import (
    MAJORITY,
    Comparison,
    Condition,
    before_fall,
    conditions_table,
    direction,
    falls_claim,
    growth_per_step,
    survives_claim,
)
from nao_hil.experiments.context import Context
from nao_hil.runs.walk import WalkOutcome
from walker.switches import NAMED

_THESIS: Final[dict[str, Any]] = msgspec.to_builtins(NAMED["thesis"])
SWITCHES: Final[dict[str, dict[str, Any]]] = {"with": _THESIS, "without": _THESIS | {"torso": "none"}}
"""By condition: the thesis' admittances and its torso control, and the same without torso control."""
TITLES: Final = ("With torso control", "Without")
PHASES: Final = "phases black: 0 DSL, 0.05 SSL, 0.10 DSR, 0.15 SSR."


DURATION: Final = 60.0
"""s of each walk."""
GROWTH: Final = 0.05
"""Least growth of the pitch without torso control in R2, degrees per step."""
SPEED: Final = 0.15
"""Least speed over ground in R5, m/s; the thesis' mean, start-up included."""
SHOWN: Final = 12.0
"""Part of the walk that the figure of R5 shows, s."""


def torso_drift(context: Context) -> Outcome:
    """R2: growth of the pitch, and falls; figure 4.9."""
    with_, without = context.run_switches("torso-drift", "static", DURATION, SWITCHES)
    growth = _growth(with_), _growth(without)
    compared = Comparison(dict(zip(TITLES, (with_, without), strict=True)))
    conditions = tuple(compared.conditions.values())
    picture = axes.pitch_and_roll(
        context.out / "torso-drift-4.9.png", with_[0].track, without[0].track, phases=True
    )
    return context.outcome(
        "torso-drift",
        "R2: the static gait under the thesis' own controllers, torso control on and off",
        "Thesis 4.2, figure 4.9: in the static gait with admittance the pitch error grows with every step "
        "until the robot falls after about 20 s; with torso control the torso is righted in every single "
        "support.",
        setup=_setup("static"),
        claims=drift_claims(conditions, growth),
        pictures=[
            Picture(
                picture,
                "Figure 4.9: pitch of the torso, and its roll",
                f"Seed {with_[0].seed}; blue without, red with torso control, cyan what it adds to the "
                f"AnklePitch of the leg that stands; {PHASES}",
            )
        ],
        tables=[conditions_table(compared.conditions)],
        findings=compared.findings(load_body(context.robot)),
        figures={
            "with": conditions[0],
            "without": conditions[1],
            "paired": compared.pair,
            "growth_with_deg": growth[0],  # median of `drift_per_step` over the runs
            "growth_without_deg": growth[1],
        },
    )


def dynamic_torso(context: Context) -> Outcome:
    """R5: falls and speed; figure 4.16."""
    with_, without = context.run_switches("dynamic-torso", "dynamic", DURATION, SWITCHES)
    compared = Comparison(dict(zip(TITLES, (with_, without), strict=True)))
    conditions = tuple(compared.conditions.values())
    shown = [walk[0].track.until(SHOWN) for walk in (with_, without)]
    picture = axes.pitch_and_roll(context.out / "dynamic-torso-4.16.png", shown[0], shown[1], phases=True)
    return context.outcome(
        "dynamic-torso",
        "R5: the dynamic gait under the thesis' own controllers, torso control on and off",
        "Thesis 4.2.3, figure 4.16: the dynamic gait falls after about 4 s without torso control and goes on "
        "stably with it.",
        setup=_setup("dynamic"),
        claims=torso_claims(*conditions),
        pictures=[
            Picture(
                picture,
                "Figure 4.16: pitch of the torso, and its roll",
                f"Seed {with_[0].seed}; blue without, red with torso control; {PHASES}",
            )
        ],
        tables=[conditions_table(compared.conditions)],
        findings=compared.findings(load_body(context.robot)),
        figures={
            "with": conditions[0],
            "without": conditions[1],
            "thesis": conditions[0],
            "paired": compared.pair,
            "falls_in_pitch": sum(
                not r.end.survived and direction(r.end) in ("forward", "backward") for r in without
            ),
        },
    )


def _setup(gait: str) -> list[tuple[str, str]]:
    return [
        ("gait", f"{gait}; leg and ankle admittance, torso control of the thesis or none"),
        ("length", f"{DURATION:g} s"),
    ]


def drift_claims(conditions: Sequence[Condition], growth: tuple[float, float]) -> tuple[Claim, ...]:
    """The verdicts of R2 on both conditions, with torso control first."""
    with_, without = conditions
    return (
        Claim(
            "Without torso control the pitch grows from step to step",
            f"{growth[1]:+.2f} deg per step without, {growth[0]:+.2f} with (medians)",
            abs(growth[1]) > max(abs(growth[0]), GROWTH),
        ),
        falls_claim(f"Without it most fall within {DURATION:g} s", without, MAJORITY),
        survives_claim(f"With it most walk for {DURATION:g} s", with_, MAJORITY),
    )


def torso_claims(with_: Condition, without: Condition) -> tuple[Claim, ...]:
    """The verdicts of R5 on both conditions."""
    return (
        falls_claim(f"Without torso control most fall within {DURATION:g} s", without, MAJORITY),
        survives_claim(f"With it most walk for {DURATION:g} s", with_, MAJORITY),
        Claim(
            f"With it at {SPEED:g} m/s or more over ground",
            f"{with_.speed:.3f} m/s (median)",
            with_.speed >= SPEED,
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
    track = before_fall(result)
    return growth_per_step(track, np.degrees(track.pitch)) if len(track) else None
