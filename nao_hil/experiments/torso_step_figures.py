"""Figures of the torso step: responses beside the fit, and their spread."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nao_hil.experiments.plant_fit import THESIS, Plant
from nao_hil.experiments.torso_responses import Responses, Vector
from nao_hil.files import atomic_path


def plot(path: Path, time: Vector, fused: Vector, true: Vector, plant: Plant) -> None:
    """Measurement, fit and the thesis' curve, each as a share of its final value.

    Args:
        path: Of the PNG.
        time: After the step, s, shape (samples,).
        fused: Responses, shape (steps, samples).
        true: The same of the true pitch.
        plant: Fit to the mean of `fused`.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    axes = figure.subplots()
    final = fused.mean(axis=0)[-100:].mean()
    axes.fill_between(time, fused.min(axis=0) / final, fused.max(axis=0) / final, alpha=0.2, label="all steps")
    axes.plot(time, fused.mean(axis=0) / final, label="fused angle, mean")
    axes.plot(time, true.mean(axis=0) / true.mean(axis=0)[-100:].mean(), ":", label="true pitch, mean")
    label = f"fit: {plant.natural_frequency_rad_s:.2f} rad/s, damping {plant.damping:.2f}"
    axes.plot(time, plant.step(time) / plant.gain, "--", label=label)
    axes.plot(time, THESIS.step(time), "k-.", linewidth=1.0, label="(4.12): 7.00 rad/s, damping 0.10")
    axes.set(xlabel="time after the step / s", ylabel="torso pitch / final value", title="Torso step")
    axes.grid(alpha=0.3)
    axes.legend()
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=120)


def plot_wave(path: Path, run: Responses, cycle: float) -> None:
    """One run as the thesis draws it (figure 4.10): input green, fused pitch red, the plant (4.12) blue.

    All are shares of the wave's amplitude; the pitch is taken about its mean, and the plant begins at rest.

    Args:
        path: Of the PNG.
        run: With its whole course.
        cycle: s
    """
    import control
    from matplotlib.figure import Figure

    from nao_hil.design.torso.transfer import thesis_plant

    time = cycle * np.arange(len(run.request))
    amplitude = float(np.abs(run.request).max())
    gain = float(run.fused.mean(axis=0)[-100:].mean())
    simulated = control.forced_response(thesis_plant(), time, run.request / amplitude).outputs
    figure = Figure(figsize=(9.0, 4.5), layout="constrained")
    panel = figure.subplots()
    panel.plot(time, run.request / amplitude, "tab:green", label="input")
    panel.plot(time, (run.angle - run.angle.mean()) / (amplitude * gain), "tab:red", label="fused pitch / gain")
    panel.plot(time, simulated, "tab:blue", linewidth=0.9, label="(4.12)")
    panel.set(xlabel="t / s", ylabel="angle / amplitude of the input")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)
