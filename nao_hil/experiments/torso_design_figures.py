"""Figures of the torso design: Bode and Nyquist diagrams, step responses."""

from __future__ import annotations

from pathlib import Path

import control
import numpy as np
from numpy.typing import NDArray

from nao_hil.design.torso.analysis import bode, frequency_response
from nao_hil.design.torso.assembly import TorsoDesign
from nao_hil.design.torso.transfer import closed_loop
from nao_hil.experiments import axes


def _omega(low: float, high: float) -> NDArray[np.float64]:
    return np.asarray(np.geomspace(low, high, 1200), dtype=np.float64)


def plot_bode(path: Path, design: TorsoDesign) -> Path:
    """Bode diagram of the open loop."""
    figure = axes.new_figure(9.0, 7.0)
    gain, phase = figure.subplots(2, 1, sharex=True)
    omega = _omega(0.1, 200.0)
    first = design.notch_q * design.plant_q
    curves = (
        ("G_s", design.plant_q, axes.BLUE),
        ("G_Notch", design.notch_q, axes.GREEN),
        ("G_L1", first, "m"),
        ("G_L2", first * control.tf([1.0], [1.0, 0.0]), axes.CYAN),
        ("G_R", design.controller_q, axes.RED),
        ("G_L", design.loop_q, "k"),
    )
    for name, system, colour in curves:
        curve = bode(system, omega)
        gain.semilogx(omega, curve.magnitude_db, color=colour, label=name)
        phase.semilogx(omega, curve.phase_deg, color=colour, label=name)
    phase.axhline(-180.0, color="k", linestyle=":", linewidth=0.9)
    gain.axhline(0.0, color="k", linestyle=":", linewidth=0.9)
    axes.finish(gain, "", "magnitude / dB")
    axes.finish(phase, "Omega / rad/s", "phase / deg")
    return axes.save(figure, path)


def plot_nyquist(path: Path, design: TorsoDesign) -> Path:
    """Nyquist diagram of the open loop."""
    figure = axes.new_figure(7.0, 5.0)
    panel = figure.subplots()
    points = frequency_response(design.loop_q, _omega(0.05, 200.0))
    panel.plot(points.real, points.imag, label="G_L(j Omega)")
    panel.plot(-1.0, 0.0, "r+", markersize=12, label="-1")
    circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 200))
    panel.plot(circle.real, circle.imag, "k:", linewidth=0.8)
    panel.set(xlim=(-2.5, 1.5), ylim=(-2.0, 2.0))
    axes.finish(panel, "Re", "Im")
    return axes.save(figure, path)


def plot_steps(path: Path, designs: dict[str, TorsoDesign]) -> Path:
    """Step responses of the closed loops."""
    figure = axes.new_figure()
    panel = figure.subplots()
    time = np.arange(0.0, 6.0, 0.01)
    plant = next(iter(designs.values())).plant_z
    panel.plot(*control.step_response(plant, time), color="0.7", label="plant without control")
    for name, design in designs.items():
        closed = closed_loop(design.controller_z, design.plant_z)
        panel.plot(*control.step_response(closed, time), label=name)
    axes.finish(panel, "t / s", "torso angle / reference")
    return axes.save(figure, path)
