"""R3: the thesis' identification experiment (figure 4.10) on the emulated robot.

Left leg stretched and standing, right leg drawn up, centre of mass over the left foot's middle, torso upright.
A square wave on the stance AnklePitch, and the fused torso pitch that follows: a plant of the form of (4.12).

The thesis prints an amplitude of 0.7 rad, which no stance on one leg survives, and normalises both signals by
it: so the gain of 1 in (4.12) is a measurement, and the amplitude is an unknown. The natural frequency falls
with it, since the sole rocks on the floor.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from bridge.body import Body, load_body
from bridge.errors import ConfigurationError
from bridge.types import Array
from emulator.scenarios import FLAT, Scenario
from emulator.wear import WearProfile, load_wear, wear_of_seed
from nao_hil.analysis.report.render import Claim, Outcome, Picture
from nao_hil.experiments import axes
from nao_hil.experiments.context import Context
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
    run_task,
)
from nao_hil.files import save_figure

AMPLITUDE: Final = 0.064
"""Of the square wave about the operating point, rad: calibrated, since 0.7 rad is a misprint. The sole
rocks."""


def plot(path: Path, time: Array, fused: Array, true: Array, plant: Plant) -> None:
    """Measurement, fit and the thesis' curve, each as a share of its final value.

    Args:
        path: Of the PNG.
        time: After the step, s, shape (samples,).
        fused: Responses, shape (steps, samples).
        true: The same of the true pitch.
        plant: Fit to the mean of `fused`.
    """
    figure = axes.new_figure(9.0, 5.0)
    panel = figure.subplots()
    final = fused.mean(axis=0)[-100:].mean()
    panel.fill_between(time, fused.min(axis=0) / final, fused.max(axis=0) / final, alpha=0.2, label="all steps")
    panel.plot(time, fused.mean(axis=0) / final, label="fused angle, mean")
    panel.plot(time, true.mean(axis=0) / true.mean(axis=0)[-100:].mean(), ":", label="true pitch, mean")
    label = f"fit: {plant.natural_frequency_rad_s:.2f} rad/s, damping {plant.damping:.2f}"
    panel.plot(time, plant.step(time) / plant.gain, "--", label=label)
    panel.plot(time, THESIS.step(time), "k-.", linewidth=1.0, label="(4.12): 7.00 rad/s, damping 0.10")
    panel.set(xlabel="time after the step / s", ylabel="torso pitch / final value", title="Torso step")
    panel.grid(alpha=0.3)
    panel.legend()
    save_figure(figure, path)


def plot_wave(path: Path, run: Responses, cycle: float) -> None:
    """One run as the thesis draws it (figure 4.10): input green, fused pitch red, the plant (4.12) blue.

    All are shares of the wave's amplitude; the pitch is taken about its mean, and the plant begins at rest.

    Args:
        path: Of the PNG.
        run: With its whole course.
        cycle: s
    """
    import control

    from nao_hil.design.torso.transfer import thesis_plant

    time = cycle * np.arange(len(run.request))
    amplitude = float(np.abs(run.request).max())
    gain = float(run.fused.mean(axis=0)[-100:].mean())
    simulated = control.forced_response(thesis_plant(), time, run.request / amplitude).outputs
    figure = axes.new_figure()
    panel = figure.subplots()
    panel.plot(time, run.request / amplitude, "tab:green", label="input")
    panel.plot(time, (run.angle - run.angle.mean()) / (amplitude * gain), "tab:red", label="fused pitch / gain")
    panel.plot(time, simulated, "tab:blue", linewidth=0.9, label="(4.12)")
    panel.set(xlabel="t / s", ylabel="angle / amplitude of the input")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    save_figure(figure, path)


class Bound(NamedTuple):
    """A figure of (4.12), and its tolerance."""

    words: str
    low: float
    high: float

    def holds(self, value: float) -> bool:
        """The value counts as the thesis' figure."""
        return self.low <= value <= self.high


BOUNDS: Final = {
    "natural_frequency_rad_s": Bound("Natural frequency 7.0 rad/s (within 15 %)", 5.95, 8.05),
    "damping": Bound("Damping 0.10 (0.07 to 0.15)", 0.07, 0.15),
    "zero_rad_s": Bound("Right-half-plane zero 8 rad/s (within 25 %)", 6.0, 10.0),
    "gain": Bound("Gain 1 (within 0.25)", 0.75, 1.25),
    "peak": Bound("Peak 2.0 of the final value, as read off figure 4.10 (within 10 %)", 1.80, 2.20),
    "undershoot": Bound("Undershoot -0.30 of the final value (within 0.08)", -0.38, -0.22),
}
"""By the key in the JSON: all of (4.12), one by one."""


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
    responses = run_once(body, wear, seed, amplitude, engine, floor=floor)
    if responses is None:
        return None
    mean = responses.fused.mean(axis=0)
    time = np.asarray(body.cycle * np.arange(1, len(mean) + 1), dtype=np.float64)
    return thesis_figures(fit_plant(time, mean)[0], read_shape(time, mean))


def torso_step_tasks(
    seeds: Sequence[int], body: Body, wear: str, amplitude: float, engine: str
) -> list[TorsoStepTask]:
    """One call of `run_task` for each seed; arguments as of `run`, with the data sheet itself."""
    return [
        TorsoStepTask(body, load_wear(wear_of_seed(wear, seed), body), seed, amplitude, engine)
        for seed in seeds
    ]


def run(
    seeds: Sequence[int],
    body: str = "nao-v3",
    wear: str = "nominal",
    out: Path | None = None,
    amplitude: float = AMPLITUDE,
    spread: Callable[[Callable[[Any], Any], list[Any]], list[Any]] | None = None,
    engine: str = "auto",
) -> dict[str, Any]:
    """The figures over some seeds; shares are of the final value, all but `true` is of the fused angle.

    Args:
        seeds: One run each.
        body: Data sheet by name or path.
        wear: Wear profile by name or path.
        out: Folder for the pictures; None: nothing is drawn.
        amplitude: Of the square wave, rad.
        spread: Calls a function with each of some arguments, over processes; None: here, one after the other.
        engine: Name of the physics engine.

    Raises:
        ConfigurationError: no stance survived, or the body cannot stand on one leg.
    """
    sheet = load_body(body)
    tasks = torso_step_tasks(seeds, sheet, wear, amplitude, engine)
    runs = spread(run_task, tasks) if spread is not None else [run_task(task) for task in tasks]
    standing = [responses for responses in runs if responses is not None]
    if not standing:
        raise ConfigurationError(
            f"No stance on one leg survived a wave of {math.degrees(amplitude):.3g} deg on {wear} drives; "
            "a smaller amplitude would be right."
        )
    fused, true = (np.concatenate([getattr(r, kind) for r in standing]) for kind in ("fused", "true"))
    time = sheet.cycle * np.arange(1, fused.shape[1] + 1)
    plant, residual = fit_plant(time, fused.mean(axis=0))
    shape = read_shape(time, fused.mean(axis=0))
    own = [fit_plant(time, r.fused.mean(axis=0))[0].natural_frequency_rad_s for r in standing]
    if out is not None:
        plot(out / "torso-step.png", time, fused, true, plant)
        plot_wave(out / "torso-step-4.10.png", standing[0], sheet.cycle)
    return {
        **thesis_figures(plant, shape),
        "rise_time_s": shape.rise_time_s,
        "residual_rms": residual / abs(shape.final),
        "n": len(fused),  # step responses averaged
        "fallen": len(runs) - len(standing),
        "natural_frequency_spread": float(np.std(own)),  # standard deviation of the seeds' own fits, rad/s
        "amplitude_rad": amplitude,
        "true": fit_plant(time, true.mean(axis=0))[0],  # the same fit to the true torso pitch
        "true_shape": read_shape(time, true.mean(axis=0)),
    }


def experiment(context: Context) -> Outcome:
    """The figures of (4.12), and figure 4.10."""
    found = run(
        context.seeds,
        context.robot,
        context.wear,
        context.out,
        spread=lambda function, tasks: context.campaign.map("torso-step", function, tasks),
        engine=context.engine,
    )
    true, shape = found["true"], found["true_shape"]
    return context.outcome(
        "torso-step",
        "R3: the torso's answer to a step of the stance ankle",
        "Thesis 4.2.1, figure 4.10, and the plant (4.12) fitted to it: rise 100 ms, peak twice the final "
        "value, an undershoot first; 7.0 rad/s, damping 0.10.",
        setup=[
            ("stance", "left leg stretched and standing, right leg drawn up, torso upright"),
            (
                "input",
                f"square wave of {math.degrees(found['amplitude_rad']):.1f} deg (the thesis prints 0.7 rad, "
                f"which no stance on one leg survives), period {PERIOD:g} s",
            ),
            ("fallen", f"{found['fallen']} of the seeds"),
        ],
        claims=[
            Claim(bound.words, f"{found[name]:.3g}", bound.holds(found[name])) for name, bound in BOUNDS.items()
        ],
        pictures=[
            Picture(
                context.out / "torso-step-4.10.png",
                "Figure 4.10: square wave on the stance ankle",
                f"Seed {context.seeds[0]}; input green, fused pitch red over its gain, the thesis' plant "
                "(4.12) blue.",
            ),
            Picture(
                context.out / "torso-step.png",
                "All steps, and the fit",
                "Shares of the final value; (4.12) dash-dotted.",
            ),
        ],
        findings=[
            f"Rise time {1e3 * found['rise_time_s']:.0f} ms (thesis about 100), gain {found['gain']:.2f} "
            "(thesis: 1).",
            f"True pitch: damping {true.damping:.2f}, zero at {1.0 / true.zero_time_s:.1f} rad/s, peak "
            f"{shape.peak:.2f}, undershoot {shape.undershoot:.2f}. So the zero of (4.12) is in the sensor: an "
            "accelerometer over the ankle, and the fused angle's filter.",
        ],
        figures=found,
    )
