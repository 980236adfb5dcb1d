"""R4: the thesis' two torso controllers (4.2.2) and the robust one, designed for the plant (4.12)."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage, ReportTable
from nao_hil.design.torso.assembly import TorsoDesign
from nao_hil.design.torso.robust import robust_design
from nao_hil.design.torso.thesis import DYNAMIC_GAIT, STATIC_GAIT, thesis_design
from nao_hil.design.torso.transfer import thesis_plant
from nao_hil.experiments.context import Context
from nao_hil.experiments.torso_design_figures import plot_bode, plot_nyquist, plot_steps

TOLERANCE: Final = 0.01
"""Relative tolerance of a design value against the one recomputed from the thesis' own numbers."""


CHECKED: Final[dict[str, dict[str, float | tuple[float, ...]]]] = {
    "static": {
        "crossover": 2.13,
        "phase_margin_deg": 60.0,
        "gain_margin": 2.13,
        "T_i": 0.0881,
        "V_i": 1.983,
        "numerator_z": (0.17738, -0.51181, 0.49248, -0.15796),
        "denominator_z": (1.0, -2.91467, 2.83405, -0.91937),
        "overshoot": 0.137,
    },
    "dynamic": {
        "crossover": 4.13,
        "phase_margin_deg": 60.0,
        "gain_margin": 1.52,
        "T_i": 0.342,
        "V_i": 2.074,
        "numerator_z": (0.69147, -2.04949, 2.02810, -0.66998),
        "denominator_z": (1.0, -2.91467, 2.83405, -0.91937),
        "overshoot": 0.165,
    },
}
"""The thesis' two designs (4.15)-(4.22), recomputed from its plant and specification with unrounded parts."""


OVERSHOOT: Final = 0.10


GAIN_MARGIN: Final = 2.5


class Design(msgspec.Struct, frozen=True, kw_only=True):
    """One controller's figures."""

    phase_margin_deg: float
    gain_margin: float
    crossover: float
    """rad/s"""
    T_i: float
    """s"""
    V_i: float
    """1/s"""
    overshoot: float
    """Of the closed loop's step response, fraction of the final value."""
    settling_time_s: float
    numerator_z: tuple[float, ...]
    """Highest power first."""
    denominator_z: tuple[float, ...]


class TorsoDesignResult(msgspec.Struct, frozen=True, kw_only=True):
    """The three designs side by side."""

    name: str = "torso-design"
    passed: bool
    """The thesis' values come out within 1 %; the robust design overshoots less than 10 %, gain margin 2.5."""
    static: Design
    dynamic: Design
    robust: Design


def experiment(context: Context) -> Outcome:
    """Design all three for the plant (4.12); figures 4.11 to 4.15."""
    plant = thesis_plant()
    designs = {
        "static": thesis_design(plant, STATIC_GAIT),
        "dynamic": thesis_design(plant, DYNAMIC_GAIT),
        "robust": robust_design(plant),
    }
    figures = {name: _figures(design) for name, design in designs.items()}
    robust = figures["robust"]
    claims = (
        *(
            Claim(
                f"{name} design, {key} = {_text(value)} (within 1 %)",
                _text(getattr(figures[name], key)),
                off(getattr(figures[name], key), value) <= TOLERANCE,
            )
            for name, values in CHECKED.items()
            for key, value in values.items()
        ),
        Claim(
            f"robust design: overshoot under {100 * OVERSHOOT:.0f} %",
            f"{100 * robust.overshoot:.1f} %",
            robust.overshoot < OVERSHOOT,
        ),
        Claim(
            f"robust design: gain margin {GAIN_MARGIN:g} or more",
            f"{robust.gain_margin:.2f}",
            robust.gain_margin >= GAIN_MARGIN,
        ),
    )
    result = TorsoDesignResult(
        passed=all(claim.holds for claim in claims),
        static=figures["static"],
        dynamic=figures["dynamic"],
        robust=robust,
    )
    page = ReportPage(
        name="torso-design",
        title="R4: the torso controllers",
        source=(
            "Thesis 4.2.2, figures 4.11 to 4.15: a notch and a PI controller by the frequency-response "
            "method for a rise time of 0.563 s (static gait) and 0.29 s (dynamic gait) and an overshoot of "
            "10 %."
        ),
        setup=(
            ("plant", "(4.12), sampled at 10 ms"),
            ("robust", "bounds hold for natural frequency, damping and zero 20 % off"),
        ),
        claims=claims,
        pictures=_pictures(context.out, designs),
        tables=(_table(figures),),
        findings=(
            "The thesis' own designs miss its 10 % of overshoot: "
            f"{100 * figures['static'].overshoot:.1f} % (static), {100 * figures['dynamic'].overshoot:.1f} % "
            f"(dynamic), which settles in {figures['dynamic'].settling_time_s:.1f} s.",
        ),
    )
    return Outcome(result, page)


def off(value: float | tuple[float, ...], expected: float | tuple[float, ...]) -> float:
    """Maximum relative difference of a number or of the elements of a polynomial; inf for another length."""
    a, b = np.atleast_1d(value), np.atleast_1d(expected)
    return float(np.abs(a / b - 1.0).max()) if a.shape == b.shape else float("inf")


def _text(value: float | tuple[float, ...]) -> str:
    return f"{value:.4g}" if isinstance(value, float) else ", ".join(f"{v:.5f}" for v in value)


def _figures(design: TorsoDesign) -> Design:
    return Design(
        phase_margin_deg=design.margins.phase_margin_deg,
        gain_margin=design.margins.gain_margin,
        crossover=design.margins.crossover,
        T_i=design.pi.T_i,
        V_i=design.pi.V_i,
        overshoot=design.step.overshoot,
        settling_time_s=design.step.settling_time,
        numerator_z=tuple(float(c) for c in design.numerator_z),
        denominator_z=tuple(float(c) for c in design.denominator_z),
    )


def _table(figures: dict[str, Design]) -> ReportTable:
    rows = tuple(
        (
            name,
            f"{d.phase_margin_deg:.1f}",
            f"{d.gain_margin:.2f}",
            f"{d.crossover:.2f}",
            f"{100 * d.overshoot:.1f} %",
            f"{d.settling_time_s:.1f}",
        )
        for name, d in figures.items()
    )
    head = ("design", "phase margin, deg", "gain margin", "crossover, rad/s", "overshoot", "settles in, s")
    return ReportTable("Designs", head, rows)


def _pictures(out: Path, designs: dict[str, TorsoDesign]) -> tuple[Picture, ...]:
    pictures = []
    for name, first, second in (("static", "4.11", "4.12"), ("dynamic", "4.13", "4.14")):
        pictures += [
            Picture(
                plot_bode(out / f"torso-design-{first}.png", designs[name]),
                f"Figure {first}: Bode diagram, {name} gait",
                "Plant G_s blue, notch green, both G_L1 magenta, with an integrator G_L2 cyan, controller "
                "G_R red, open loop G_L black.",
            ),
            Picture(
                plot_nyquist(out / f"torso-design-{second}.png", designs[name]),
                f"Figure {second}: Nyquist curve of the open loop, {name} gait",
                "Omega from 0.05 to 200 rad/s.",
            ),
        ]
    return (
        *pictures,
        Picture(
            plot_steps(out / "torso-design-4.15.png", designs),
            "Figure 4.15: step responses of the closed loops",
            "Beside the plant's own: what is asked of the torso, and what it does.",
        ),
    )
