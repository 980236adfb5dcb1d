"""R4: the thesis' two torso controllers (4.2.2) and the robust one, designed for the plant (4.12)."""

from __future__ import annotations

import functools
from typing import Any, Final

import control
import msgspec
import numpy as np
from matplotlib.figure import Figure

from bridge.types import Array
from nao_hil.analysis.report.render import Claim, Columns, table
from nao_hil.design.torso.analysis import bode, frequency_response
from nao_hil.design.torso.assembly import TorsoDesign
from nao_hil.design.torso.robust import robust_design
from nao_hil.design.torso.thesis import DYNAMIC_GAIT, STATIC_GAIT, thesis_design
from nao_hil.design.torso.transfer import closed_loop, thesis_plant
from nao_hil.experiments import axes
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Drawing, Experiment, Measured, bounded

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
Designs = dict[str, TorsoDesign]


def _omega(low: float, high: float) -> Array:
    return np.asarray(np.geomspace(low, high, 1200), dtype=np.float64)


def _draw_bode(figure: Figure, measured: Measured[Designs], name: str) -> None:
    gain, phase = figure.subplots(2, 1, sharex=True)
    omega, design = _omega(0.1, 200.0), measured.results[name]
    first = design.notch_q * design.plant_q
    curves = (
        ("G_s", design.plant_q, axes.BLUE),
        ("G_Notch", design.notch_q, axes.GREEN),
        ("G_L1", first, "m"),
        ("G_L2", first * control.tf([1.0], [1.0, 0.0]), axes.CYAN),
        ("G_R", design.controller_q, axes.RED),
        ("G_L", design.loop_q, "k"),
    )
    for label, system, colour in curves:
        curve = bode(system, omega)
        gain.semilogx(omega, curve.magnitude_db, color=colour, label=label)
        phase.semilogx(omega, curve.phase_deg, color=colour, label=label)
    phase.axhline(-180.0, color="k", linestyle=":", linewidth=0.9)
    gain.axhline(0.0, color="k", linestyle=":", linewidth=0.9)
    axes.finish(gain, "", "magnitude / dB")
    axes.finish(phase, "Omega / rad/s", "phase / deg")


def _draw_nyquist(figure: Figure, measured: Measured[Designs], name: str) -> None:
    panel = figure.subplots()
    points = frequency_response(measured.results[name].loop_q, _omega(0.05, 200.0))
    panel.plot(points.real, points.imag, label="G_L(j Omega)")
    panel.plot(-1.0, 0.0, "r+", markersize=12, label="-1")
    circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 200))
    panel.plot(circle.real, circle.imag, "k:", linewidth=0.8)
    panel.set(xlim=(-2.5, 1.5), ylim=(-2.0, 2.0))
    axes.finish(panel, "Re", "Im")


def _draw_steps(figure: Figure, measured: Measured[Designs]) -> None:
    panel, time = figure.subplots(), np.arange(0.0, 6.0, 0.01)
    plant = next(iter(measured.results.values())).plant_z
    panel.plot(*control.step_response(plant, time), color="0.7", label="plant without control")
    for name, design in measured.results.items():
        closed = closed_loop(design.controller_z, design.plant_z)
        panel.plot(*control.step_response(closed, time), label=name)
    axes.finish(panel, "t / s", "torso angle / reference")


class Design(msgspec.Struct, frozen=True, kw_only=True):
    """One controller's figures."""

    phase_margin_deg: float
    gain_margin: float
    crossover: float
    """Crossover frequency, rad/s."""
    T_i: float
    """Integration time of the PI controller, s."""
    V_i: float
    """1/s"""
    overshoot: float
    """Overshoot of the closed loop's step response, fraction of the final value."""
    settling_time_s: float
    numerator_z: tuple[float, ...]
    """Highest power first."""
    denominator_z: tuple[float, ...]


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


def _measure(_: Context) -> Designs:
    """Design all three for the plant (4.12)."""
    plant = thesis_plant()
    return {
        "static": thesis_design(plant, STATIC_GAIT),
        "dynamic": thesis_design(plant, DYNAMIC_GAIT),
        "robust": robust_design(plant),
    }


def _claims(found: dict[str, Any]) -> list[Claim]:
    robust = found["robust"]
    return [
        *(
            Claim(
                f"{name} design, {key} = {_text(value)} (within 1 %)",
                _text(getattr(found[name], key)),
                off(getattr(found[name], key), value) <= TOLERANCE,
            )
            for name, values in CHECKED.items()
            for key, value in values.items()
        ),
        Claim(
            f"robust design: overshoot under {100 * OVERSHOOT:.0f} %",
            f"{100 * robust.overshoot:.1f} %",
            robust.overshoot < OVERSHOOT,
        ),
        bounded(
            f"robust design: gain margin {GAIN_MARGIN:g} or more",
            robust.gain_margin,
            GAIN_MARGIN,
            words="{:.2f}",
        ),
    ]


COLUMNS: Final[Columns] = {
    "design": "{0[0]}",
    "phase margin, deg": "{0[1].phase_margin_deg:.1f}",
    "gain margin": "{0[1].gain_margin:.2f}",
    "crossover, rad/s": "{0[1].crossover:.2f}",
    "overshoot": lambda item: f"{100 * item[1].overshoot:.1f} %",
    "settles in, s": "{0[1].settling_time_s:.1f}",
}
TORSO_DESIGN: Final = Experiment(
    title="R4: the torso controllers",
    source="Thesis 4.2.2, figures 4.11 to 4.15: a notch and a PI controller by the frequency-response method "
    "for a rise time of 0.563 s (static gait) and 0.29 s (dynamic gait) and an overshoot of 10 %, which its "
    "own designs miss.",
    robot=False,
    setup=(
        ("plant", "(4.12), sampled at 10 ms"),
        ("robust", "bounds hold for natural frequency, damping and zero 20 % off"),
    ),
    measure=_measure,
    quantities=lambda measured: {name: _figures(design) for name, design in measured.results.items()},
    claims=lambda measured: _claims(measured.figures),
    tables=lambda measured: [table("Designs", measured.figures.items(), COLUMNS)],
    pictures=(
        *(
            drawing
            for name, first, second in (("static", "4.11", "4.12"), ("dynamic", "4.13", "4.14"))
            for drawing in (
                Drawing(
                    f"torso-design-{first}.png",
                    functools.partial(_draw_bode, name=name),
                    f"Figure {first}: Bode diagram, {name} gait",
                    "Plant G_s blue, notch green, both G_L1 magenta, with an integrator G_L2 cyan, controller "
                    "G_R red, open loop G_L black.",
                    (9.0, 7.0),
                ),
                Drawing(
                    f"torso-design-{second}.png",
                    functools.partial(_draw_nyquist, name=name),
                    f"Figure {second}: Nyquist curve of the open loop, {name} gait",
                    "Omega from 0.05 to 200 rad/s.",
                    (7.0, 5.0),
                ),
            )
        ),
        Drawing(
            "torso-design-4.15.png",
            _draw_steps,
            "Figure 4.15: step responses of the closed loops",
            "With the plant's own step response.",
        ),
    ),
)
