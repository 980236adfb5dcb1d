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
from typing import Any, Final, NamedTuple, TypeAlias

import msgspec
import numpy as np

from bridge.body import Body, load_body
from bridge.errors import ConfigurationError
from emulator.scenarios import FLAT, Scenario
from emulator.wear import WearProfile, load_wear, wear_of_seed
from nao_hil.analysis.report.page import Claim, Outcome, Picture, ReportPage
from nao_hil.experiments.context import Context
from nao_hil.experiments.plant_fit import Plant, Shape, fit_plant, read_shape
from nao_hil.experiments.setup import seed_words
from nao_hil.experiments.torso_responses import PERIOD, Responses, TorsoStepTask, run_once, run_task
from nao_hil.experiments.torso_step_figures import plot, plot_wave
from nao_hil.files import write_bytes

AMPLITUDE: Final = 0.062
"""Of the square wave about the operating point, rad: calibrated, since 0.7 rad is a misprint. The sole
rocks."""


class Bound(NamedTuple):
    """A figure of (4.12), and what counts as the same."""

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
"""By the field of `TorsoStepResult`: all of (4.12), one by one."""


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


class TorsoStepResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out; shares are of the final value, everything but `true` is of the fused angle."""

    name: str = "torso-step"
    passed: bool
    """All figures of (4.12) within `BOUNDS`."""
    natural_frequency_rad_s: float
    damping: float
    zero_rad_s: float
    """Zero in the right half plane, positive; it stands for the delay, too."""
    gain: float
    """Torso angle per ankle angle at rest."""
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


Spread: TypeAlias = Callable[
    [Callable[[TorsoStepTask], Responses | None], list[TorsoStepTask]], list[Responses | None]
]
"""Runs tasks somewhere: a function, and its arguments."""


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
    spread: Spread | None = None,
    engine: str = "auto",
) -> TorsoStepResult:
    """The experiment over some seeds.

    Args:
        seeds: One run each.
        body: Data sheet by name or path.
        wear: Wear profile by name or path.
        out: Folder for `torso-step.json` and `torso-step.png`; None: nothing is written.
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
    figures: dict[str, Any] = {**thesis_figures(plant, shape)}
    result = TorsoStepResult(
        passed=all(bound.holds(figures[name]) for name, bound in BOUNDS.items()),
        **figures,
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
        write_bytes(out / "torso-step.json", msgspec.json.format(msgspec.json.encode(result)))
        plot(out / "torso-step.png", time, fused, true, plant)
        plot_wave(out / "torso-step-4.10.png", standing[0], sheet.cycle)
    return result


def experiment(context: Context) -> Outcome:
    """The experiment as part of a campaign: its page, figure 4.10, and the verdict."""
    result = run(
        context.seeds,
        context.robot,
        context.wear,
        context.out,
        spread=lambda function, tasks: context.campaign.map("torso-step", function, tasks),
        engine=context.engine,
    )
    claims = tuple(
        Claim(bound.words, f"{getattr(result, figure):.3g}", bound.holds(getattr(result, figure)))
        for figure, bound in BOUNDS.items()
    )
    page = ReportPage(
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
                f"square wave of {math.degrees(result.amplitude_rad):.1f} deg (the thesis prints 0.7 rad, "
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
            f"Rise time {1e3 * result.rise_time_s:.0f} ms (thesis about 100), gain {result.gain:.2f} "
            "(thesis: 1).",
            f"{result.true.damping:.2f}, zero at {1.0 / result.true.zero_time_s:.1f} rad/s, peak "
            f"{result.true_shape.peak:.2f}, undershoot {result.true_shape.undershoot:.2f}. So the zero of "
            "(4.12) is in the sensor: an accelerometer over the ankle, and the fused angle's filter.",
        ),
    )
    return Outcome(result, page)


def main() -> None:
    """Five seeds on the nominal V3; figures in the folder `torso-step`."""
    result = run(range(5), out=Path("torso-step"))
    print(msgspec.json.format(msgspec.json.encode(result)).decode())


if __name__ == "__main__":
    main()
