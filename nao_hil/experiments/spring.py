"""R7: the spring of the leg admittance (thesis 4.4, figure 4.7), and that no force drives it to its pole."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from nao_hil.experiments import axes
from nao_hil.experiments.context import seed_words
from nao_hil.experiments.experiment import Drawing, Experiment, Measured, bounded
from walker.mechanisms.admittance import LegAdmittance, LegParameters

THESIS: Final = LegParameters()
THESIS_POLE: Final = math.pi**2 / 300.0
"""|e| at which the force is infinite with the thesis' parameters, m."""
THESIS_STIFFNESS: Final = 0.5 * 300.0 / (2.0 * math.pi)
"""k_c / (2 pi k_a), N/m."""
CYCLES: Final = 2000
"""Cycles of each force history."""
CYCLE: Final = 0.01
"""Cycle of the spring's equation, s."""
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


def _quantities(measured: Measured[float]) -> dict[str, Any]:
    return {
        "pole_m": THESIS.pole,
        "stiffness_n_per_m": (THESIS.spring(1e-6) - THESIS.spring(-1e-6)) / 2e-6,  # about zero
        "force_at_10_mm": THESIS.spring(0.01),
        "deflection_max": measured.results,  # largest |e| over the pole, of all force histories
        "n": len(measured.context.seeds),
    }


def _draw(figure: Figure, _: Measured[float]) -> None:
    panel, p = figure.subplots(), THESIS
    e = np.linspace(-0.995, 0.995, 2001) * p.pole
    panel.plot(e, [p.spring(value) for value in e.tolist()], label="F_Foot,d(e)")
    for side, label in ((-1.0, None), (1.0, "pole")):
        panel.axvline(side * p.pole, color="k", linestyle=":", linewidth=0.9, label=label)
    panel.set_ylim(-15.0, 15.0)
    axes.finish(panel, "e_n / m", "F_Foot,d / N")


SPRING: Final = Experiment(
    title="R7: the spring of the leg admittance",
    source="Thesis (4.4), figure 4.7: k_a = 1/300, k_b = 0, k_c = 0.5, k_d = 0.",
    robot=False,
    setup=lambda measured: (
        ("spring", "k_a = 1/300 m, k_b = 0, k_c = 0.5 N, k_d = 0"),
        (
            "force histories",
            f"random sizes and swings, {CYCLES} cycles, up to {LARGEST:.0e} N, seeds "
            f"{seed_words(measured.context.seeds)}",
        ),
    ),
    measure=lambda context: max(deflection(seed, THESIS) for seed in context.seeds),
    quantities=_quantities,
    claims=lambda measured: [
        bounded(
            "The pole is at |e| = pi^2 / 300 = 32.9 mm",
            measured.figures["pole_m"],
            0.99 * THESIS_POLE,
            1.01 * THESIS_POLE,
            "{:.5f} m",
        ),
        bounded(
            "Soft about zero: k_c / (2 pi k_a) = 23.9 N/m",
            measured.figures["stiffness_n_per_m"],
            0.99 * THESIS_STIFFNESS,
            1.01 * THESIS_STIFFNESS,
            "{:.2f} N/m",
        ),
        bounded(
            "No history of forces drives the foot's offset to the pole",
            measured.figures["deflection_max"],
            high=math.nextafter(1.0, 0.0),
            words="at most {:.9f} of it",
        ),
    ],
    pictures=(
        Drawing(
            "spring-4.7.png",
            _draw,
            "Figure 4.7: the spring's characteristic",
            "Force over deflection between the poles.",
            (7.0, 4.5),
        ),
    ),
)
