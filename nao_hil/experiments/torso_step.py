"""R3: the thesis' identification experiment (figure 4.10) on the emulated robot.

Left leg stretched and standing, right leg drawn up, centre of mass over the left foot's middle, torso upright.
A square wave on the stance AnklePitch, and the fused torso pitch that follows: a plant of the form of (4.12).

The thesis prints an amplitude of 0.7 rad, which no stance on one leg survives, and normalises both signals by
it: so the gain of 1 in (4.12) is a measurement, and the amplitude is an unknown. The natural frequency falls
with it, since the sole rocks on the floor.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.types import Array
from emulator.scenarios import FLAT, Scenario
from emulator.wear import WearProfile, load_wear, wear_of_seed
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Drawing, Experiment, Measured, bounded
from nao_hil.experiments.torso_responses import (
    PERIOD,
    THESIS,
    Plant,
    Responses,
    Shape,
    TorsoStepTask,
    fit_plant,
    read_shape,
    run_once,
)

AMPLITUDE: Final = 0.064
"""Amplitude of the square wave about the operating point, rad: calibrated, since 0.7 rad is a misprint. The
sole rocks."""


BOUNDS: Final = {
    "natural_frequency_rad_s": ("Natural frequency 7.0 rad/s (within 15 %)", 5.95, 8.05),
    "damping": ("Damping 0.10 (0.07 to 0.15)", 0.07, 0.15),
    "zero_rad_s": ("Right-half-plane zero 8 rad/s (within 25 %)", 6.0, 10.0),
    "gain": ("Gain 1 (within 0.25)", 0.75, 1.25),
    "peak": ("Peak 2.0 of the final value, as read off figure 4.10 (within 10 %)", 1.80, 2.20),
    "undershoot": ("Undershoot -0.30 of the final value (within 0.08)", -0.38, -0.22),
}
"""All figures of (4.12) by their key in the JSON: words, least and largest value."""


def thesis_figures(plant: Plant, shape: Shape) -> dict[str, float]:
    """The figures of (4.12) of a fused pitch's step response, by the names of `BOUNDS`."""
    return {
        "natural_frequency_rad_s": plant.natural_frequency_rad_s,
        "damping": plant.damping,
        "zero_rad_s": 1.0 / plant.zero_time_s,
        "gain": plant.gain,
        "peak": shape.peak,
        "undershoot": shape.undershoot,
    }


def torso_figures(
    body: Body,
    wear: WearProfile,
    engine: str,
    seed: int,
    amplitude: float = AMPLITUDE,
    floor: Scenario = FLAT,
) -> dict[str, float] | None:
    """The figures of (4.12) of one robot, by the names of `BOUNDS`; None: its stance on one leg fell.

    Args:
        body: Of the robot.
        wear: Of its drives and sensors.
        engine: `pybullet` or `mujoco`.
        seed: Of the run.
        amplitude: Of the square wave, rad.
        floor: Its floor.
    """
    responses = run_once(
        TorsoStepTask(body=body, wear=wear, seed=seed, engine=engine, amplitude=amplitude, floor=floor)
    )
    if responses is None:
        return None
    mean = responses.fused.mean(axis=0)
    time = response_time(body, mean)
    return thesis_figures(fit_plant(time, mean)[0], read_shape(time, mean))


def response_time(body: Body, response: Array) -> Array:
    """After the step, s."""
    return np.asarray(body.cycle * np.arange(1, len(response) + 1), dtype=np.float64)


def torso_step_tasks(context: Context, amplitude: float) -> list[TorsoStepTask]:
    """A task for each seed; the amplitude of the square wave in rad."""
    body = context.body
    return [
        TorsoStepTask(
            body=body,
            wear=load_wear(wear_of_seed(context.wear, seed), body),
            seed=seed,
            engine=context.engine,
            amplitude=amplitude,
        )
        for seed in context.seeds
    ]


class TorsoSteps(NamedTuple):
    """Responses of the runs."""

    standing: list[Responses]
    fallen: int
    amplitude: float
    """Amplitude of the square wave, rad."""
    time: Array
    """After the step, s, shape (samples,)."""

    @property
    def fused(self) -> Array:
        """Responses of the fused angle, shape (steps, samples)."""
        return np.concatenate([run.fused for run in self.standing])

    @property
    def true(self) -> Array:
        """The same of the true pitch."""
        return np.concatenate([run.true for run in self.standing])


def measure(context: Context, amplitude: float = AMPLITUDE) -> TorsoSteps:
    """One run per seed.

    Raises:
        ConfigurationError: no stance survived, or the body cannot stand on one leg.
    """
    runs: list[Responses | None] = context.map("torso-step", run_once, torso_step_tasks(context, amplitude))
    standing = [run for run in runs if run is not None]
    if not standing:
        raise ConfigurationError(
            f"No stance on one leg survived a wave of {math.degrees(amplitude):.3g} deg on {context.wear} "
            "drives; a smaller amplitude would be right."
        )
    time = response_time(context.body, standing[0].fused[0])
    return TorsoSteps(standing, len(runs) - len(standing), amplitude, time)


def quantities(steps: TorsoSteps) -> dict[str, Any]:
    """The figures over the seeds; shares are of the final value, all but `true` is of the fused angle."""
    time, fused, true = steps.time, steps.fused.mean(axis=0), steps.true.mean(axis=0)
    (plant, residual), shape = fit_plant(time, fused), read_shape(time, fused)
    own = [fit_plant(time, run.fused.mean(axis=0))[0].natural_frequency_rad_s for run in steps.standing]
    return {
        **thesis_figures(plant, shape),
        "rise_time_s": shape.rise_time_s,
        "residual_rms": residual / abs(shape.final),
        "n": len(steps.fused),  # step responses averaged
        "fallen": steps.fallen,
        "natural_frequency_spread": float(np.std(own)),  # standard deviation of the seeds' own fits, rad/s
        "amplitude_rad": steps.amplitude,
        "true": fit_plant(time, true)[0],  # the same fit to the true torso pitch
        "true_shape": read_shape(time, true),
    }


def _draw_steps(figure: Figure, measured: Measured[TorsoSteps]) -> None:
    """Measurement, fit and the thesis' curve, each as a share of its final value."""
    steps, panel = measured.results, figure.subplots()
    time, fused, true = steps.time, steps.fused, steps.true.mean(axis=0)
    plant, final = fit_plant(time, fused.mean(axis=0))[0], fused.mean(axis=0)[-100:].mean()
    panel.fill_between(time, fused.min(axis=0) / final, fused.max(axis=0) / final, alpha=0.2, label="all steps")
    panel.plot(time, fused.mean(axis=0) / final, label="fused angle, mean")
    panel.plot(time, true / true[-100:].mean(), ":", label="true pitch, mean")
    label = f"fit: {plant.natural_frequency_rad_s:.2f} rad/s, damping {plant.damping:.2f}"
    panel.plot(time, plant.step(time) / plant.gain, "--", label=label)
    panel.plot(time, THESIS.step(time), "k-.", linewidth=1.0, label="(4.12): 7.00 rad/s, damping 0.10")
    panel.set(xlabel="time after the step / s", ylabel="torso pitch / final value", title="Torso step")
    panel.grid(alpha=0.3)
    panel.legend()


def _draw_wave(figure: Figure, measured: Measured[TorsoSteps]) -> None:
    """One run as the thesis draws it (figure 4.10): input green, fused pitch red, the plant (4.12) blue.

    All are shares of the wave's amplitude; the pitch is taken about its mean, and the plant begins at rest.
    """
    import control

    from nao_hil.design.torso.transfer import thesis_plant

    run, panel = measured.results.standing[0], figure.subplots()
    time = measured.body.cycle * np.arange(len(run.request))
    amplitude = float(np.abs(run.request).max())
    gain = float(run.fused.mean(axis=0)[-100:].mean())
    simulated = control.forced_response(thesis_plant(), time, run.request / amplitude).outputs
    panel.plot(time, run.request / amplitude, "tab:green", label="input")
    panel.plot(time, (run.angle - run.angle.mean()) / (amplitude * gain), "tab:red", label="fused pitch / gain")
    panel.plot(time, simulated, "tab:blue", linewidth=0.9, label="(4.12)")
    panel.set(xlabel="t / s", ylabel="angle / amplitude of the input")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))


TORSO_STEP: Final = Experiment(
    title="R3: the torso's answer to a step of the stance ankle",
    source="Thesis 4.2.1, figure 4.10, and the plant (4.12) fitted to it: rise 100 ms, peak twice the final "
    "value, an undershoot first; 7.0 rad/s, damping 0.10.",
    setup=lambda measured: [
        ("stance", "left leg stretched and standing, right leg drawn up, torso upright"),
        (
            "input",
            f"square wave of {math.degrees(measured.results.amplitude):.1f} deg (the thesis prints 0.7 rad, "
            f"which no stance on one leg survives), period {PERIOD:g} s",
        ),
        ("fallen", f"{measured.results.fallen} of the seeds"),
    ],
    measure=measure,
    quantities=lambda measured: quantities(measured.results),
    claims=lambda measured: [
        bounded(words, measured.figures[name], low, high) for name, (words, low, high) in BOUNDS.items()
    ],
    pictures=(
        Drawing(
            "torso-step-4.10.png",
            _draw_wave,
            "Figure 4.10: square wave on the stance ankle",
            "Seed {seed}; input green, fused pitch red over its gain, the thesis' plant (4.12) blue.",
        ),
        Drawing(
            "torso-step.png",
            _draw_steps,
            "All steps, and the fit",
            "Shares of the final value; (4.12) dash-dotted.",
            (9.0, 5.0),
        ),
    ),
    findings=lambda measured: [
        f"The zero is at {measured.figures['zero_rad_s']:.1f} rad/s, that of the true pitch at "
        f"{1.0 / measured.figures['true'].zero_time_s:.1f}: the difference is the sensor's, an accelerometer "
        "over the ankle, and the fused angle's filter."
    ],
)
