"""R3: the thesis' identification experiment (figure 4.10) on the emulated robot.

Left leg stretched and standing, right leg drawn up, centre of mass over the left foot's middle, torso upright.
A square wave on the stance AnklePitch, and the fused torso pitch that follows: a plant of the form of (4.12).

The thesis draws an input of 0.7 rad, which no stance on one leg survives; it is taken for its normalisation.
Here the wave is small enough that the sole stays flat on the ground.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.datasheet import Body, load_body
from bridge.errors import ConfigurationError
from bridge.joints import INDEX
from bridge.messages import ActuatorFrame, Quaternion
from emulator.robot import EmulatedRobot
from emulator.wear import WearProfile, load_wear
from lab.experiments.context import Context
from lab.experiments.one_leg import one_leg_stance
from lab.experiments.page import Claim, Outcome, Page, Picture
from lab.experiments.plant_fit import THESIS, Plant, Shape, fit_plant, read_shape
from lab.experiments.setup import seed_words
from walker.torso.sign import ankle_pitch_from_lean

Vector = NDArray[np.float64]
AMPLITUDE: Final = math.radians(1.5)
"""Of the square wave about the operating point, rad: beyond it the sole tips over the toes."""
PERIOD: Final = 8.0
"""s"""
PERIODS: Final = 2
SPREAD: Final = math.radians(0.1)
"""Standard deviation of the leg joints' operating points between seeds, rad: nobody stands twice the same."""
FREQUENCY_TARGET: Final = 7.0
FREQUENCY_TOLERANCE: Final = 0.15
PEAK_RANGE: Final = (1.6, 2.1)


class TorsoStepResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out; shares are of the final value, everything but `true` is of the fused angle."""

    name: str = "torso-step"
    passed: bool
    """Natural frequency within 15 % of 7.0 rad/s, peak 1.6 to 2.1, an undershoot."""
    natural_frequency_rad_s: float
    damping: float
    zero_time_s: float
    """Positive: right-half-plane zero at 1 / zero_time. It stands for the delay, too."""
    gain: float
    """Torso angle per ankle angle at rest; (4.12) is normalised to 1."""
    peak: float
    undershoot: float
    rise_time_s: float
    residual_rms: float
    n: int
    """Step responses averaged."""
    fallen: int
    """Runs in which the stance did not survive."""
    natural_frequency_spread: float
    """Standard deviation of the seeds' own fits, rad/s; 0 for one seed."""
    amplitude_rad: float
    true: Plant
    """The same fit to the true torso pitch."""
    true_shape: Shape


class Responses(msgspec.Struct, frozen=True, kw_only=True):
    """Step responses of one run, one row per step, to a step of size 1."""

    fused: Any
    """Shape (steps, samples)."""
    true: Any
    request: Any
    """The whole run: request of the AnklePitch about its operating point, as a lean, rad, shape (cycles,)."""
    angle: Any
    """The fused pitch of the same, rad."""


def _pitch(orientation: Quaternion) -> float:
    """AngleY of an orientation, rad, positive nose down."""
    x, y, z, w = orientation
    return math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))


def run_once(body: Body, wear: WearProfile, seed: int, amplitude: float) -> Responses | None:
    """One robot, one square wave; the first half period, which starts from rest, is left out. None: it fell."""
    random = np.random.default_rng(seed)
    stance = np.array(one_leg_stance(body))
    legs = [i for name, i in INDEX.items() if name[1:].startswith(("Hip", "Knee", "Ankle"))]
    stance[legs] += random.normal(0.0, SPREAD, len(legs))
    half = round(0.5 * PERIOD / body.cycle)
    fused, true, leans = [], [], []
    with EmulatedRobot(body, seed=seed, posture=stance.tolist(), wear=wear, settle=2.0) as robot:
        for k in range(2 * PERIODS * half):
            request = stance.copy()
            lean = amplitude if (k // half) % 2 == 0 else -amplitude
            request[INDEX["LAnklePitch"]] += ankle_pitch_from_lean(lean)
            frame = robot.advance(
                ActuatorFrame(reply_to=k, position=tuple(request.tolist()), stiffness=(1.0,) * len(request))
            )
            truth = robot.truth()
            leans.append(lean)
            fused.append(frame.angle[1])
            true.append(_pitch(truth.torso_orientation))
            if truth.fell:
                return None
    return Responses(
        fused=_cut(fused, half, amplitude),
        true=_cut(true, half, amplitude),
        request=np.array(leans),
        angle=np.array(fused),
    )


class _Task(msgspec.Struct, frozen=True):
    """A call of `run_once` for a worker."""

    body: Body
    wear: WearProfile
    seed: int
    amplitude: float


def _run_task(task: _Task) -> Responses | None:
    return run_once(task.body, task.wear, task.seed, task.amplitude)


def _cut(track: Sequence[float], half: int, amplitude: float) -> Vector:
    """Responses to the steps after the first, each from where it started, over the size of its step."""
    angle = np.array(track)
    rows = []
    for k in range(half, len(angle), half):
        step = -2.0 * amplitude if (k // half) % 2 else 2.0 * amplitude
        rows.append((angle[k : k + half] - angle[k - 50 : k].mean()) / step)
    return np.array(rows)


def run(
    seeds: Sequence[int],
    body: str = "nao-v3",
    wear: str = "nominal",
    out: Path | None = None,
    amplitude: float = AMPLITUDE,
    spread: Callable[[Callable[[_Task], Responses | None], list[_Task]], list[Responses | None]] | None = None,
) -> TorsoStepResult:
    """The experiment over some seeds.

    Args:
        seeds: One run each.
        body: Data sheet by name or path.
        wear: Wear profile by name or path.
        out: Folder for `torso-step.json` and `torso-step.png`; None: nothing is written.
        amplitude: Of the square wave, rad.
        spread: Calls a function with each of some arguments, over processes; None: here, one after the other.

    Raises:
        ConfigurationError: no stance survived, or the body cannot stand on one leg.
    """
    sheet, profile = load_body(body), load_wear(wear)
    tasks = [_Task(sheet, profile, seed, amplitude) for seed in seeds]
    runs = spread(_run_task, tasks) if spread is not None else [_run_task(task) for task in tasks]
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
    off = abs(plant.natural_frequency_rad_s / FREQUENCY_TARGET - 1.0)
    result = TorsoStepResult(
        passed=off <= FREQUENCY_TOLERANCE
        and PEAK_RANGE[0] <= shape.peak <= PEAK_RANGE[1]
        and shape.undershoot < 0.0,
        natural_frequency_rad_s=plant.natural_frequency_rad_s,
        damping=plant.damping,
        zero_time_s=plant.zero_time_s,
        gain=plant.gain,
        peak=shape.peak,
        undershoot=shape.undershoot,
        rise_time_s=shape.rise_time_s,
        residual_rms=residual / abs(shape.final),
        n=len(fused),
        fallen=len(runs) - len(standing),
        natural_frequency_spread=float(np.std(own)),
        amplitude_rad=amplitude,
        true=fit_plant(time, true.mean(axis=0))[0],
        true_shape=read_shape(time, true.mean(axis=0)),
    )
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        (out / "torso-step.json").write_bytes(msgspec.json.format(msgspec.json.encode(result)))
        plot(out / "torso-step.png", time, fused, true, plant)
        plot_wave(out / "torso-step-4.10.png", standing[0], sheet.cycle)
    return result


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
    figure.savefig(path, dpi=120)


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

    from walker.torso.transfer import thesis_plant

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
    figure.savefig(path, dpi=110)


def experiment(context: Context) -> Outcome:
    """The experiment as part of a campaign: its page, figure 4.10, and the verdict."""
    result = run(
        context.seeds,
        context.robot,
        context.wear,
        context.out,
        spread=lambda function, tasks: context.campaign.map("torso-step", function, tasks),
    )
    off = abs(result.natural_frequency_rad_s / FREQUENCY_TARGET - 1.0)
    claims = (
        Claim(
            "Natural frequency 7.0 rad/s (within 15 %)",
            f"{result.natural_frequency_rad_s:.2f} rad/s",
            off <= FREQUENCY_TOLERANCE,
        ),
        Claim(
            "Peak about twice the final value (1.6 to 2.1)",
            f"{result.peak:.2f}",
            PEAK_RANGE[0] <= result.peak <= PEAK_RANGE[1],
        ),
        Claim(
            "An undershoot first",
            f"{100 * result.undershoot:.0f} % of the final value",
            result.undershoot < 0.0,
        ),
    )
    page = Page(
        name="torso-step",
        title="R3: the torso's answer to a step of the stance ankle",
        source=(
            "Thesis 4.2.1, figure 4.10, and the plant (4.12) fitted to it: rise 100 ms, peak twice the "
            "final value, an undershoot first; 7.0 rad/s, damping 0.10."
        ),
        setup=(
            ("stance", "left leg stretched and standing, right leg drawn up, torso upright"),
            (
                "input",
                f"square wave of {math.degrees(result.amplitude_rad):.1f} deg (the thesis draws 0.7 rad, "
                f"which no stance on one leg survives), period {PERIOD:g} s",
            ),
            ("robot", f"{context.robot}, {context.wear} drives and sensors"),
            ("seeds", f"{seed_words(context.seeds)}; {result.fallen} fell"),
        ),
        claims=claims,
        pictures=(
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
        ),
        findings=(
            f"Damping {result.damping:.2f} (thesis 0.10), rise time {1e3 * result.rise_time_s:.0f} ms (about "
            f"100), zero at {1.0 / result.zero_time_s:.1f} rad/s in the right half plane (8), gain "
            f"{result.gain:.2f}.",
        ),
    )
    return Outcome(result, page)


def main() -> None:
    """Five seeds on the nominal V3; figures in the folder `torso-step`."""
    result = run(range(5), out=Path("torso-step"))
    print(msgspec.json.format(msgspec.json.encode(result)).decode())


if __name__ == "__main__":
    main()
