"""R7: the spring of the leg admittance (thesis 4.4, figure 4.7), and that no force drives it to its pole."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import numpy as np

from nao_hil.analysis.report.render import Claim, Outcome, Picture
from nao_hil.experiments import axes
from nao_hil.experiments.context import Context, seed_words
from nao_hil.files import save_figure
from walker.mechanisms.admittance import LegAdmittance, LegParameters

THESIS_POLE: Final = math.pi**2 / 300.0
"""|e| at which the force is infinite with the thesis' parameters, m."""


CYCLES: Final = 2000
"""Of each force history."""
CYCLE: Final = 0.01
"""s"""
LARGEST: Final = 1e6
"""Forces are drawn up to this size, N, each size as likely as the next."""


def deflection(seed: int, parameters: LegParameters, cycles: int = CYCLES) -> float:
    """Largest |e + k_b| over the pole that a random history of forces and swings leads to."""
    random = np.random.default_rng(seed)
    leg = LegAdmittance(parameters)
    worst = 0.0
    for k in range(cycles):
        size = 10.0 ** random.uniform(-2.0, math.log10(LARGEST))
        progress = (k % 150) / 150.0
        force = float(size * random.choice([0.0, 1.0]))
        if (k // 150) % 2 == 0:
            leg.swing(force, CYCLE, progress=progress)
        else:
            leg.shift(float(random.uniform(-0.01, 0.01)))
        worst = max(worst, abs(leg.e + parameters.k_b))
    return worst / parameters.pole


def experiment(context: Context) -> Outcome:
    """The curve, its pole, and the property."""
    thesis = LegParameters()
    worst = max(deflection(seed, thesis) for seed in context.seeds)
    slope = (thesis.spring(1e-6) - thesis.spring(-1e-6)) / 2e-6
    figures = {
        "pole_m": thesis.pole,
        "stiffness_n_per_m": slope,  # about zero
        "force_at_10_mm": thesis.spring(0.01),
        "deflection_max": worst,  # largest |e| over the pole, of all force histories
        "n": len(context.seeds),
    }
    return context.outcome(
        "spring",
        "R7: the spring of the leg admittance",
        "Thesis (4.4), figure 4.7: k_a = 1/300, k_b = 0, k_c = 0.5, k_d = 0.",
        walks=False,
        setup=(
            ("spring", "k_a = 1/300 m, k_b = 0, k_c = 0.5 N, k_d = 0"),
            ("force histories", f"random sizes and swings, seeds {seed_words(context.seeds)}"),
        ),
        claims=(
            Claim(
                "The pole is at |e| = pi^2 / 300 = 32.9 mm",
                f"{1e3 * thesis.pole:.2f} mm",
                abs(thesis.pole / THESIS_POLE - 1.0) < 0.01,
            ),
            Claim(
                "Soft about zero: k_c / (2 pi k_a) = 23.9 N/m",
                f"{slope:.2f} N/m; {thesis.spring(0.01):.3f} N at 10 mm",
                abs(slope / (0.5 * 300.0 / (2.0 * math.pi)) - 1.0) < 0.01,
            ),
            Claim(
                "No history of forces drives the foot's offset to the pole",
                f"at most {worst:.9f} of it in {len(context.seeds)} histories of {CYCLES} cycles "
                f"with forces up to {LARGEST:.0e} N",
                worst < 1.0,
            ),
        ),
        pictures=(
            Picture(
                _plot(context.out / "spring-4.7.png", thesis),
                "Figure 4.7: the spring's characteristic",
                "Force over deflection between the poles, with the slope at zero.",
            ),
        ),
        figures=figures,
    )


def _plot(path: Path, p: LegParameters) -> Path:
    figure = axes.new_figure(7.0, 4.5)
    panel = figure.subplots()
    e = np.linspace(-0.995, 0.995, 2001) * p.pole
    panel.plot(e, [p.spring(value) for value in e.tolist()], label="F_Foot,d(e)")
    for side in (-1.0, 1.0):
        panel.axvline(
            side * p.pole, color="k", linestyle=":", linewidth=0.9, label="pole" if side > 0 else None
        )
    panel.set_ylim(-15.0, 15.0)
    axes.finish(panel, "e_n / m", "F_Foot,d / N")
    return save_figure(figure, path)
