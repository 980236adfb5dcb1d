"""R2 and R5: both gaits under the thesis' own controllers, with and without torso control (4.2; 4.9, 4.16)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np
from matplotlib.figure import Figure

from bridge.rotations import pitch
from nao_hil.analysis.report.render import Claim
from nao_hil.experiments import axes
from nao_hil.experiments.conditions import (
    MAJORITY,
    Comparison,
    before_fall,
    direction,
    falls_claim,
    growth_per_step,
    median_over,
)
from nao_hil.experiments.context import Task
from nao_hil.experiments.experiment import Drawing, Measured, bounded, comparison
from nao_hil.runs.walk import WalkOutcome
from walker.switches import NAMED

SWITCHES: Final[dict[str, dict[str, Any]]] = {
    "with": {"controller.switches": msgspec.to_builtins(NAMED["thesis"])},
    "without": {"controller.switches": msgspec.to_builtins(NAMED["thesis"]) | {"torso": "none"}},
}
"""By condition: the thesis' admittances and its torso control, and the same without torso control."""
DURATION: Final = 60.0
"""s of each walk."""
GROWTH: Final = 0.05
"""Least growth of the pitch without torso control in R2, degrees per step."""
SPEED: Final = 0.15
"""Least speed over ground in R5, m/s; the thesis' mean, start-up included."""
SHOWN: Final = 12.0
"""Part of the walk that the figure of R5 shows, s."""
PHASES: Final = "phases black: 0 DSL, 0.05 SSL, 0.10 DSR, 0.15 SSR."


def _draw(figure: Figure, measured: Measured[Comparison], until: float = DURATION) -> None:
    with_, without = (walks[0].track.until(until) for walks in measured.results.walks.values())
    axes.pitch_and_roll(figure, with_, without, phases=True)


def _most_walk_only_with_it(measured: Measured[Comparison], control: str) -> list[Claim]:
    figures = measured.figures
    return [
        falls_claim(f"Without {control} most fall within {DURATION:g} s", figures["without"], MAJORITY),
        bounded(f"With it most walk for {DURATION:g} s", figures["with"], MAJORITY),
    ]


def drift_claims(measured: Measured[Comparison]) -> Sequence[Claim]:
    """The verdicts of R2."""
    with_, without = (measured.figures[f"growth_{condition}_deg"] for condition in SWITCHES)
    grows = Claim(
        "Without torso control the pitch grows from step to step",
        f"{without:+.2f} deg per step without, {with_:+.2f} with (medians)",
        abs(without) > max(abs(with_), GROWTH),
    )
    return [grows, *_most_walk_only_with_it(measured, "it")]


def torso_claims(measured: Measured[Comparison]) -> Sequence[Claim]:
    """The verdicts of R5."""
    speed = measured.figures["with"].speed
    fast = bounded(f"With it at {SPEED:g} m/s or more over ground", speed, SPEED, words="{:.3f} m/s (median)")
    return [*_most_walk_only_with_it(measured, "torso control"), fast]


def drift_per_step(result: WalkOutcome) -> float | None:
    """Slope of the mean true pitch of a step against its number, up to a second before a fall, deg per step.

    None: fewer than three steps.
    """
    track = before_fall(result)
    return (
        growth_per_step(track, np.degrees(pitch(track["world/truth.torso_orientation"])))
        if track.rows
        else None
    )


def _falls_in_pitch(results: Sequence[WalkOutcome]) -> int:
    return sum(not r.end.survived and direction(r.end) in ("forward", "backward") for r in results)


def _setup(gait: str) -> tuple[tuple[str, str], ...]:
    return (
        ("gait", f"{gait}; leg and ankle admittance, torso control of the thesis or none"),
        ("length", f"{DURATION:g} s"),
    )


TORSO_DRIFT: Final = comparison(
    title="R2: the static gait under the thesis' own controllers, torso control on and off",
    source="Thesis 4.2, figure 4.9: in the static gait with admittance the pitch error grows with every step "
    "until the robot falls after about 20 s; with torso control the torso is righted in every single support.",
    setup=_setup("static"),
    conditions=Task("static", DURATION).each("torso-drift", SWITCHES),
    quantities=lambda measured: {
        f"growth_{condition}_deg": median_over(walks, drift_per_step)
        for condition, walks in measured.results.walks.items()
    },
    claims=drift_claims,
    pictures=(
        Drawing(
            "torso-drift-4.9.png",
            _draw,
            "Figure 4.9: pitch of the torso, and its roll",
            "Seed {seed}; blue without, red with torso control, cyan its addition to the AnklePitch of the "
            f"leg that stands; {PHASES}",
            axes.TALL,
        ),
    ),
)
DYNAMIC_TORSO: Final = comparison(
    title="R5: the dynamic gait under the thesis' own controllers, torso control on and off",
    source="Thesis 4.2.3, figure 4.16: the dynamic gait falls after about 4 s without torso control and goes "
    "on stably with it.",
    setup=_setup("dynamic"),
    conditions=Task("dynamic", DURATION).each("dynamic-torso", SWITCHES),
    quantities=lambda measured: {
        "thesis": measured.results.conditions["with"],
        "falls_in_pitch": _falls_in_pitch(measured.results.walks["without"]),
    },
    claims=torso_claims,
    pictures=(
        Drawing(
            "dynamic-torso-4.16.png",
            lambda figure, measured: _draw(figure, measured, SHOWN),
            "Figure 4.16: pitch of the torso, and its roll",
            f"Seed {{seed}}; blue without, red with torso control; {PHASES}",
            axes.TALL,
        ),
    ),
)
