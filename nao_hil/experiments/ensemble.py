"""Robots that agree with what is published: approximate Bayesian computation by rejection.

The unknowns are drawn evenly from their ranges (Sobol' points). A robot is accepted when its torso step has
every figure of (4.12) within the bounds of the claims, and its leg drives are as the published servo table
says. No walk is looked at: those are there to test the ensemble.

Few draws are accepted. So once some have been tried, a linear model of their figures foretells those of further
draws, and only draws that it puts within the bounds, widened by its own error, are tried.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from bridge.body import Body
from bridge.body.quantities import joint_no_load_speed
from emulator.wear import WearProfile
from emulator.wear.ensemble import Member, RobotEnsemble, profile_of, unknowns
from nao_hil.experiments import servo_bench
from nao_hil.experiments.plant_fit import fit_plant, read_shape
from nao_hil.experiments.servo_bench import LEGS, Vector, part
from nao_hil.experiments.servo_measure import LEAST_FALL, STEP, cruise_speed, motion_times
from nao_hil.experiments.torso_responses import PERIODS, run_once
from nao_hil.experiments.torso_step import AMPLITUDE, BOUNDS, thesis_figures
from nao_hil.files import write_text

BATCH: Final = 16
"""Robots tried at a time."""
UNFILTERED: Final = 40
"""Robots with figures before the model is asked."""
WIDENED: Final = 2.0
"""Standard deviations of the model's error by which the bounds are widened for its forecast."""
MOST: Final = 2048
"""Robots tried before it gives up."""
MOST_DRAWN: Final = 2**18
"""Points drawn, likewise."""
DRIVES: Final = ("LKneePitch", "LHipRoll", "LAnklePitch", "LHipPitch")
"""Whose delay is measured; those first that turn most robots away."""
RUN_SEED: Final = 0
"""Of the robot in its torso step."""


class Draw(msgspec.Struct, frozen=True):
    """A robot to be tried, for a worker."""

    body: Body
    values: tuple[float, ...]
    """Of all unknowns."""
    engine: str


def torso_figures(
    body: Body, wear: WearProfile, engine: str, seed: int = RUN_SEED, periods: int = PERIODS
) -> dict[str, float] | None:
    """The figures of (4.12) by the names of `BOUNDS`; None: the stance on one leg fell.

    Args:
        body: Of the robot.
        wear: Of its drives and sensors.
        engine: `pybullet` or `mujoco`.
        seed: Of the run.
        periods: Of the square wave, over which responses are averaged.
    """
    responses = run_once(body, wear, seed, AMPLITUDE, engine, periods)
    if responses is None:
        return None
    mean = responses.fused.mean(axis=0)
    time = np.asarray(body.cycle * np.arange(1, len(mean) + 1), dtype=np.float64)
    return thesis_figures(fit_plant(time, mean)[0], read_shape(time, mean))


def drive_delay(body: Body, wear: WearProfile, engine: str, joint: str) -> float:
    """From request to motion of a joint, s."""
    track = servo_bench.step_response(body, wear, engine, joint, STEP)
    return motion_times(body, track, LEGS.index(joint), STEP)[0]


def delays_agree(body: Body, wear: WearProfile, engine: str) -> bool:
    """From request to motion every drive takes 36 ms to 4 cycles."""
    return all(0.0359 < drive_delay(body, wear, engine, joint) < 4.01 * body.cycle for joint in DRIVES)


def power_agrees(body: Body, wear: WearProfile, engine: str) -> bool:
    """The knee has the data sheet's speed without load within 5 %, and without stiffness hips and knees fall.

    Stall torques are the data sheet's by construction.
    """
    track = servo_bench.run_through(body, wear, engine, "LKneePitch")
    speed = cruise_speed(track[:, 0], part(track, 1)[:, LEGS.index("LKneePitch")])
    if abs(speed / joint_no_load_speed(body, "LKneePitch") - 1.0) > 0.05:
        return False
    fall = servo_bench.fall_limp(body, wear, engine)
    return all(way > LEAST_FALL for joint, way in zip(LEGS, fall.tolist(), strict=True) if "Ankle" not in joint)


class Trial(msgspec.Struct, frozen=True):
    """What came of a draw."""

    figures: dict[str, float] | None
    """Of a short wave; None: it fell, or its delays do not agree."""
    member: Member | None
    """None: it does not agree with what is published."""


def try_robot(draw: Draw) -> Trial:
    """Try a robot, the cheapest first: delays, a short wave of one step, the whole torso step, power."""
    wear = profile_of(dict(zip(unknowns(), draw.values, strict=True)), "draw")
    if not delays_agree(draw.body, wear, draw.engine):
        return Trial(None, None)
    short = torso_figures(draw.body, wear, draw.engine, periods=1)
    figures = torso_figures(draw.body, wear, draw.engine) if _agree(short) else None
    if figures is None or not _agree(figures) or not power_agrees(draw.body, wear, draw.engine):
        return Trial(short, None)
    rounded = {name: float(f"{value:.5g}") for name, value in figures.items()}
    return Trial(short, Member(values=draw.values, figures=rounded))


def _agree(figures: dict[str, float] | None) -> bool:
    return figures is not None and all(bound.holds(figures[name]) for name, bound in BOUNDS.items())


class Forecast:
    """A linear model of the figures of (4.12) over the shares of the unknowns' ranges.

    Args:
        shares: Shape (n, k), n larger than k + 1.
        figures: Shape (n, m).
    """

    def __init__(self, shares: Vector, figures: Vector) -> None:
        rows = self._rows(shares)
        self._weights = np.linalg.lstsq(rows, figures, rcond=None)[0]
        left = figures - rows @ self._weights
        self._error = np.sqrt((left**2).sum(axis=0) / (len(rows) - rows.shape[1]))

    def may_agree(self, shares: Vector) -> NDArray[np.bool_]:
        """Of draws, shape (n, k): their figures may be within the bounds."""
        figures, margin = self._rows(shares) @ self._weights, WIDENED * self._error
        low, high = (np.array([getattr(bound, end) for bound in BOUNDS.values()]) for end in ("low", "high"))
        inside: NDArray[np.bool_] = ((figures >= low - margin) & (figures <= high + margin)).all(axis=1)
        return inside

    @staticmethod
    def _rows(shares: Vector) -> Vector:
        return np.hstack([np.ones((len(shares), 1)), shares])


def design_ensemble(
    body: Body,
    members: int,
    seed: int,
    engine: str,
    command: str,
    spread: Callable[[Callable[[Draw], Trial], Sequence[Draw]], Sequence[Trial]],
    keep: Callable[[RobotEnsemble], None],
) -> RobotEnsemble:
    """Draw robots until enough are accepted.

    Args:
        body: Of all of them.
        members: Wanted.
        seed: Of the draws.
        engine: Name of the physics engine.
        command: That made it, to be written beside it.
        spread: Calls a function with each of some arguments; fewer results: it was stopped.
        keep: Told of the ensemble after each batch.

    Returns:
        The members in the order of the draws; fewer than wanted after `MOST` trials or `MOST_DRAWN` points, or
        when stopped.
    """
    points = qmc.Sobol(len(unknowns()), seed=seed)
    tried: list[list[float]] = []
    trials: list[Trial] = []
    waiting: list[list[float]] = []
    drawn, going = 0, True
    while True:
        found = [trial.member for trial in trials if trial.member is not None]
        ensemble = RobotEnsemble(
            command=command,
            robot=body.name,
            engine=engine,
            seed=seed,
            drawn=drawn,
            tried=len(trials),
            unknowns=tuple(unknowns()),
            members=tuple(found[:members]),
        )
        keep(ensemble)
        if len(found) >= members or len(trials) >= MOST or not going:
            return ensemble
        known = sum(trial.figures is not None for trial in trials)
        forecast = _forecast(tried, trials) if known >= UNFILTERED else None
        while len(waiting) < BATCH and drawn < MOST_DRAWN:
            more = points.random(BATCH)
            drawn += BATCH
            waiting += (more[forecast.may_agree(more)] if forecast else more).tolist()
        batch, waiting = waiting[:BATCH], waiting[BATCH:]
        results = spread(try_robot, [Draw(body, _values(row), engine) for row in batch])
        going = len(results) == BATCH
        tried += batch[: len(results)]
        trials += results


def _forecast(tried: Sequence[Sequence[float]], trials: Sequence[Trial]) -> Forecast:
    """From the robots with figures."""
    stood = [(row, each.figures) for row, each in zip(tried, trials, strict=True) if each.figures is not None]
    return Forecast(np.array([row for row, _ in stood]), np.array([list(f.values()) for _, f in stood]))


def _values(shares: Sequence[float]) -> tuple[float, ...]:
    pairs = zip(unknowns().values(), shares, strict=True)
    return tuple(float(f"{unknown.at(share):.5g}") for unknown, share in pairs)


def write_ensemble(path: Path, ensemble: RobotEnsemble) -> None:
    """Write it as TOML, a robot in two lines.

    Raises:
        ConfigurationError: the file cannot be written.
    """
    head = msgspec.toml.encode(msgspec.structs.replace(ensemble, members=())).decode()
    lines = [line for line in head.splitlines() if not line.startswith("members")]
    for member in ensemble.members:
        figures = ", ".join(f"{name} = {value:g}" for name, value in member.figures.items())
        values = ", ".join(f"{value!r}" for value in member.values)
        lines += ["", "[[members]]", f"values = [{values}]", f"figures = {{{figures}}}"]
    write_text(path, "\n".join(lines) + "\n")
