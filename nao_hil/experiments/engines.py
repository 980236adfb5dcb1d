"""The same robot on both physics engines: torso step, drives and walks side by side."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from bridge.body import load_body
from bridge.errors import ConfigurationError
from emulator.engine.catalogue import ENGINES, require_engine
from emulator.wear import load_wear
from nao_hil.analysis.report.page import Claim, Outcome, ReportPage, ReportTable
from nao_hil.experiments.arms import Arm, arm
from nao_hil.experiments.context import Context
from nao_hil.experiments.plant_fit import fit_plant, read_shape
from nao_hil.experiments.servo_measure import ServoRow, measure
from nao_hil.experiments.setup import setup_rows
from nao_hil.experiments.torso_responses import Responses, TorsoStepTask, run_task
from nao_hil.experiments.torso_step import AMPLITUDE
from nao_hil.runs.campaign import Interrupted

DIFFERENCES: Final = (
    "What differs between the engines beside rounding: the rotors (on PyBullet in the link's tensor, where "
    "they resist a turn of the whole limb too and lower the natural frequency by 5 to 6 %; on MuJoCo an "
    "armature of the joint), the solver (sequential impulses against Newton to convergence), the friction cone "
    "(a pyramid against an ellipse), and the points of the outline that carry a sole (PyBullet chooses four, "
    "with an error of the stiffness against tilting of up to 40 %; MuJoCo has eight)."
)
"""For people who see two numbers that differ."""


@dataclass(frozen=True)
class EnginesSetup:
    """The experiment's numbers."""

    walks: tuple[tuple[str, float], ...] = (
        ("static", 20.0),
        ("dynamic", 15.0),
        ("huang", 15.0),
        ("omni", 10.0),
    )
    """Gaits, and how long each is walked, s; with the gait's own velocity."""
    frequency: float = 0.05
    """Fraction by which the natural frequencies may differ."""
    speed: float = 0.10
    """Fraction by which walking speeds may differ."""


class Mean(msgspec.Struct, frozen=True, kw_only=True):
    """A mean with the bounds of its 95 % interval (Student's)."""

    mean: float
    low: float
    high: float
    n: int

    def words(self, unit: str = "", digits: int = 3) -> str:
        """For people."""
        return f"{self.mean:.{digits}g} ({self.low:.{digits}g} to {self.high:.{digits}g}){unit}"


class WalkPair(msgspec.Struct, frozen=True, kw_only=True):
    """One gait on both engines."""

    gait: str
    arms: dict[str, Arm]
    speeds: dict[str, Mean | None]
    """m/s over ground of those that walk on in both; None: fewer than two."""
    ratio: Mean | None
    """Speed on MuJoCo over that on PyBullet, seed by seed."""


class EnginesResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came out."""

    name: str = "engines"
    passed: bool
    frequency: dict[str, Mean]
    """Of the torso step, by engine, rad/s."""
    peak: dict[str, Mean]
    """Of the torso step over its final value, by engine."""
    servo: dict[str, float]
    """Largest difference of a leg drive between the engines, as a fraction of PyBullet's, by quantity."""
    walks: tuple[WalkPair, ...]


def mean_of(values: Sequence[float]) -> Mean:
    """Mean and interval; with one value the interval is infinite."""
    n, mean = len(values), float(np.mean(values))
    half = math.inf
    if n > 1:
        half = float(student.ppf(0.975, n - 1) * np.std(values, ddof=1) / math.sqrt(n))
    return Mean(mean=mean, low=mean - half, high=mean + half, n=n)


def _all(context: Context, name: str, function: Callable[[Any], Any], tasks: Sequence[Any]) -> list[Any]:
    """A function's results for all tasks.

    Raises:
        Interrupted: it was stopped before the last.
    """
    results = context.campaign.map(name, function, tasks)
    if len(results) < len(tasks):
        raise Interrupted
    return results


def _torso(context: Context) -> dict[str, tuple[Mean, Mean]]:
    """Natural frequency and peak by engine, each seed fitted by itself."""
    body = load_body(context.robot)
    wear = load_wear(context.wear, body)
    tasks = [TorsoStepTask(body, wear, seed, AMPLITUDE, engine) for seed in context.seeds for engine in ENGINES]
    runs: list[Responses | None] = _all(context, "torso-step", run_task, tasks)
    found: dict[str, tuple[Mean, Mean]] = {}
    for engine in ENGINES:
        own = [run for task, run in zip(tasks, runs, strict=True) if task.engine == engine]
        fits = [_fit(run.fused.mean(axis=0), body.cycle) for run in own if run is not None]
        if not fits:
            raise ConfigurationError(f"No stance on one leg survived on {engine} with {context.wear} drives.")
        frequencies, peaks = zip(*fits, strict=True)
        found[engine] = mean_of(frequencies), mean_of(peaks)
    return found


def _fit(response: NDArray[np.float64], cycle: float) -> tuple[float, float]:
    """Natural frequency, rad/s, and peak of a step response."""
    time = np.asarray(cycle * np.arange(1.0, len(response) + 1.0), dtype=np.float64)
    return fit_plant(time, response)[0].natural_frequency_rad_s, read_shape(time, response).peak


def _measure(task: tuple[str, str, str]) -> tuple[ServoRow, ...]:
    """The leg drives of a robot and wear on an engine, for a worker."""
    robot, wear, engine = task
    body = load_body(robot)
    return measure(body, load_wear(wear, body), engine)


def _servos(context: Context) -> dict[str, float]:
    """Largest difference between the engines over the leg drives."""
    tables = _all(context, "drives", _measure, [(context.robot, context.wear, e) for e in ENGINES])
    worst = {}
    for quantity in ("no_load_speed", "request_to_motion", "backlash", "stall_torque"):
        pairs = [[getattr(row, quantity) for row in rows] for rows in zip(*tables, strict=True)]
        worst[quantity] = max(abs(b / a - 1.0) if a else abs(b) for a, b in pairs)
    return worst


def _walks(context: Context, gait: str, duration: float) -> WalkPair:
    arms = []
    for engine in ENGINES:
        on = replace(context, changes=msgspec.structs.replace(context.changes, engine=engine))
        arms.append(on.walks(f"{gait} on {engine}", gait, duration, keep_track=False))
    results = dict(zip(ENGINES, context.run(*arms), strict=True))
    standing = [{r.seed: r.end.speed for r in results[engine] if r.end.survived} for engine in ENGINES]
    both = [seed for seed in standing[0] if seed in standing[1]]
    speeds: dict[str, Mean | None] = dict.fromkeys(ENGINES)
    ratio = None
    if len(both) > 1:
        speeds = {e: mean_of([s[seed] for seed in both]) for e, s in zip(ENGINES, standing, strict=True)}
        ratio = mean_of([standing[1][seed] / standing[0][seed] for seed in both])
    return WalkPair(gait=gait, arms={e: arm(r) for e, r in results.items()}, speeds=speeds, ratio=ratio)


def experiment(context: Context, setup: EnginesSetup | None = None) -> Outcome:
    """Everything on both engines, in one table.

    Raises:
        ConfigurationError: an engine is not installed.
    """
    setup = setup or EnginesSetup()
    for engine in ENGINES:
        require_engine(engine)
    torso = _torso(context)
    servo = _servos(context)
    walks = tuple(_walks(context, gait, duration) for gait, duration in setup.walks)
    frequencies = {engine: torso[engine][0] for engine in ENGINES}
    claims = (
        _frequency_claim(frequencies, setup.frequency),
        *(claim for pair in walks for claim in _walk_claims(pair, setup.speed)),
    )
    result = EnginesResult(
        passed=all(claim.holds for claim in claims),
        frequency=frequencies,
        peak={engine: torso[engine][1] for engine in ENGINES},
        servo=servo,
        walks=walks,
    )
    page = ReportPage(
        name="engines",
        title="PyBullet and MuJoCo: the same robot",
        source="No part of the thesis: a claim that holds on two engines does not hang on one contact model.",
        setup=setup_rows(context, [(f"{gait} walk", f"{seconds:g} s") for gait, seconds in setup.walks]),
        claims=claims,
        tables=(_table(result),),
        findings=(DIFFERENCES,),
    )
    return Outcome(result, page)


def _frequency_claim(found: dict[str, Mean], least: float) -> Claim:
    """The intervals of both frequencies within a fraction of PyBullet's mean."""
    first, second = (found[engine] for engine in ENGINES)
    ends = (abs(second.high - first.low), abs(first.high - second.low))
    return Claim(
        f"Natural frequency of the torso step within {100.0 * least:.0f} %",
        f"{first.words()} and {second.words(' rad/s')}",
        max(ends) <= least * first.mean,
    )


def _walk_claims(pair: WalkPair, least: float) -> tuple[Claim, Claim]:
    one, other = (pair.arms[engine] for engine in ENGINES)
    apart = one.interval[0] > other.interval[1] or other.interval[0] > one.interval[1]
    ratio = pair.ratio
    return (
        Claim(
            f"{pair.gait}: speeds within {100.0 * least:.0f} %",
            "fewer than two walk on in both" if ratio is None else f"ratio {ratio.words()}, n = {ratio.n}",
            ratio is not None and 1.0 - least <= ratio.low and ratio.high <= 1.0 + least,
        ),
        Claim(f"{pair.gait}: survival intervals overlap", f"{one.words()}; {other.words()}", not apart),
    )


def _table(result: EnginesResult) -> ReportTable:
    rows = [
        ("torso step, natural frequency, rad/s", *(result.frequency[e].words() for e in ENGINES)),
        ("torso step, peak over final value", *(result.peak[e].words() for e in ENGINES)),
    ]
    for pair in result.walks:
        rows.append((f"{pair.gait}: walk on", *(pair.arms[e].words() for e in ENGINES)))
        speeds = [pair.speeds[e] for e in ENGINES]
        rows.append((f"{pair.gait}: m/s over ground", *("-" if s is None else s.words() for s in speeds)))
    for quantity, worst in result.servo.items():
        words = f"{100.0 * worst:.2g} % apart in the worst leg joint"
        rows.append((f"drives: {quantity.replace('_', ' ')}", "reference", words))
    return ReportTable("Both engines; 95 % intervals in brackets", ("", *ENGINES), tuple(rows))
