"""Robots that agree with the measurements of real ones: approximate Bayesian computation.

The calibrated unknowns are drawn from their ranges and measured as the real robots were: the torso step on a
V3, tracking errors in a walk of a V6, a knee held out by a V5. A robot is accepted when every figure is within
its bounds. Population Monte Carlo: each generation is drawn around the best robots so far (a mixture of normal
kernels), and an accepted robot counts with the inverse of the density that proposed it, so that the ensemble
is even over the part of the ranges that agrees. The other unknowns are drawn evenly: no figure depends on them.

No walk is judged, neither its survival nor its speed: walks test the ensemble.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
from scipy.stats import qmc

from bridge.body import load_body
from bridge.types import Array
from emulator.scenarios import Scenario
from emulator.scenarios.ground import ScenarioFloor
from emulator.wear import WearProfile
from emulator.wear.ensemble import Member, RobotEnsemble, profile_of, unknowns
from nao_hil.experiments.context import Context
from nao_hil.experiments.experiment import Experiment, Measured, bounded
from nao_hil.experiments.robot_figures import FIGURES, knee_hold, tracking
from nao_hil.experiments.torso_step import BOUNDS, torso_figures
from nao_hil.files import write_text

FIRST: Final = 128
"""Robots of the first generation."""
GENERATION: Final = 32
"""Robots of each later one."""
PARENTS: Final = 16
"""Best robots around which a generation is drawn."""
WIDENED: Final = 0.3
"""Kernels' covariance over the parents'."""
MAX_TRIALS: Final = 2000
"""Robots tried before it gives up."""
RUN_SEED: Final = 0
"""Of the robots' noise while they are measured."""
HOPELESS: Final = 5.0
"""Distance from which on the more expensive figures are not measured."""
COMPARED: Final = {name: (low, high) for name, (_, low, high) in BOUNDS.items()} | {
    name: (figure.low, figure.high) for name, figure in FIGURES.items() if name.startswith(("tracking", "knee"))
}
"""Bounds of all figures."""


class Draw(msgspec.Struct, frozen=True):
    """A robot to be tried, for a worker."""

    values: dict[str, float]
    """By unknown."""
    engine: str


class Trial(msgspec.Struct, frozen=True):
    """Figures of a robot."""

    figures: dict[str, float]
    """The measured ones."""
    distance: float
    """Largest deviation of a figure from the middle of its bounds, over half their width; 1 or less: it
    agrees."""


def distance(figures: dict[str, float]) -> float:
    """See `Trial.distance`; of the figures that are there."""
    off = [
        abs(value - 0.5 * sum(COMPARED[name])) / (0.5 * (COMPARED[name][1] - COMPARED[name][0]))
        for name, value in figures.items()
    ]
    return max(off, default=0.0)


def try_robot(draw: Draw) -> Trial:
    """Measure a robot, the cheapest figure first."""
    figures: dict[str, float] = {}
    values, engine = draw.values, draw.engine

    def wear(robot: str) -> WearProfile:
        return profile_of(values, "draw", load_body(robot))

    held = knee_hold(load_body("nao-v5"), wear("nao-v5"), engine)
    figures["knee_hold.knee_pitch"] = math.degrees(held)
    if (far := distance(figures)) > HOPELESS:
        return Trial(figures, far)
    floor = Scenario(floor=ScenarioFloor(stiffness=values["hard_floor"]))
    step = torso_figures(
        load_body("nao-v3"), wear("nao-v3"), engine, RUN_SEED, amplitude=values["step_amplitude"], floor=floor
    )
    if step is None:
        return Trial(figures, 2.0 * HOPELESS)
    figures |= step
    if (far := distance(figures)) > HOPELESS:
        return Trial(figures, far)
    walked = tracking(load_body("nao-v6"), wear("nao-v6"), RUN_SEED, engine)
    if walked is None:
        return Trial(figures, 2.0 * HOPELESS)
    figures |= walked.figures()
    return Trial(figures, distance(figures))


class Sampler:
    """Draws of the calibrated unknowns as shares of their ranges, (n, k).

    Args:
        size: Of a draw, k.
        random: Source of all draws.
    """

    def __init__(self, size: int, random: np.random.Generator) -> None:
        self._size, self._random = size, random
        self.shares: Array = np.zeros((0, size))
        """All draws."""
        self._kernels: list[tuple[int, Array, Array]] = []
        """Of each generation: draws, parents, covariance; no parents: even."""

    def first(self, number: int) -> Array:
        """Even draws."""
        drawn: Array = qmc.LatinHypercube(self._size, rng=self._random).random(number)
        self._keep(drawn, np.zeros((0, self._size)), np.eye(self._size))
        return drawn

    def around(self, parents: Array, number: int) -> Array:
        """Draws around the best ones, (m, k), inside the ranges."""
        covariance = WIDENED * np.cov(parents.T) + 1e-4 * np.eye(self._size)
        rows: list[Array] = []
        while len(rows) < number:
            parent = parents[self._random.integers(len(parents))]
            row = self._random.multivariate_normal(parent, covariance)
            if (row >= 0.0).all() and (row <= 1.0).all():
                rows.append(row)
        self._keep(np.array(rows), parents, covariance)
        return np.array(rows)

    def _keep(self, drawn: Array, parents: Array, covariance: Array) -> None:
        self.shares = np.vstack([self.shares, drawn])
        self._kernels.append((len(drawn), parents, covariance))

    def weights(self, rows: Array) -> Array:
        """Inverse density of the mixture of all proposals, (n,), sum 1; cuts at the ranges are ignored."""
        density = np.zeros(len(rows))
        for number, parents, covariance in self._kernels:
            share = number / len(self.shares)
            if not len(parents):
                density += share
                continue
            inverse = np.linalg.inv(covariance)
            off = rows[:, None, :] - parents[None, :, :]
            power = np.einsum("nmi,ij,nmj->nm", off, inverse, off)
            scale = math.sqrt((2.0 * math.pi) ** self._size * np.linalg.det(covariance))
            density += share * np.exp(-0.5 * power).mean(axis=1) / scale
        weights: Array = 1.0 / density
        weights /= weights.sum()
        return weights


def design_ensemble(
    members: int,
    seed: int,
    engine: str,
    command: str,
    spread: Callable[[Callable[[Draw], Trial], Sequence[Draw]], Sequence[Trial]],
    keep: Callable[[RobotEnsemble], None],
) -> RobotEnsemble:
    """Draw robots until twice as many as wanted are accepted, and take the wanted number of them.

    Args:
        members: Wanted.
        seed: Of the draws.
        engine: Name of the physics engine.
        command: Written into the file of the robots.
        spread: Calls a function with each of some arguments; fewer results: stopped.
        keep: Takes the ensemble after each generation.

    Returns:
        The members; fewer than wanted after `MAX_TRIALS` trials, or when stopped.
    """
    random, free = (np.random.default_rng([seed, k]) for k in range(2))
    table = unknowns()
    calibrated = [name for name, unknown in table.items() if unknown.calibrated]
    sampler = Sampler(len(calibrated), random)
    draws: list[Draw] = []
    trials: list[Trial] = []
    while True:
        if not trials:
            batch = sampler.first(FIRST)
        else:
            best = sorted(range(len(trials)), key=lambda i: trials[i].distance)[:PARENTS]
            batch = sampler.around(sampler.shares[best], GENERATION)
        drawn = [
            Draw(_values({**dict.fromkeys(table), **dict(zip(calibrated, row, strict=True))}, free), engine)
            for row in batch.tolist()
        ]
        results = spread(try_robot, drawn)
        draws += drawn[: len(results)]
        trials += results
        accepted = [i for i, trial in enumerate(trials) if trial.distance <= 1.0]
        ensemble = RobotEnsemble(
            command=command,
            engine=engine,
            seed=seed,
            tried=len(trials),
            accepted=len(accepted),
            unknowns=tuple(table),
            members=tuple(_member(draws[i], trials[i]) for i in _choose(sampler, accepted, members, seed)),
        )
        keep(ensemble)
        if len(accepted) >= 2 * members or len(trials) >= MAX_TRIALS or len(results) < len(drawn):
            return ensemble


def _choose(sampler: Sampler, accepted: list[int], members: int, seed: int) -> list[int]:
    """Draws that become members: without repetition, with the weights of the proposal."""
    if len(accepted) <= members:
        return accepted
    weights = sampler.weights(sampler.shares[accepted])
    chosen = np.random.default_rng([seed, 2]).choice(accepted, members, replace=False, p=weights)
    return sorted(chosen.tolist())


def _member(draw: Draw, trial: Trial) -> Member:
    figures = {name: float(f"{value:.5g}") for name, value in trial.figures.items()}
    return Member(values=tuple(draw.values.values()), figures=figures)


def _values(shares: dict[str, float | None], random: np.random.Generator) -> dict[str, float]:
    """Values of all unknowns; those without a share are drawn evenly."""
    table, free = unknowns(), random.random(len(shares)).tolist()
    return {
        name: float(f"{table[name].at(free[i] if share is None else share):.5g}")
        for i, (name, share) in enumerate(shares.items())
    }


def write_ensemble(path: Path, ensemble: RobotEnsemble) -> None:
    """Write it as TOML, a robot in two lines.

    Raises:
        ConfigurationError: the file cannot be written.
    """
    head = msgspec.toml.encode(msgspec.structs.replace(ensemble, members=())).decode()
    lines = [line for line in head.splitlines() if not line.startswith("members")]
    for member in ensemble.members:
        figures = ", ".join(f'"{name}" = {value:g}' for name, value in member.figures.items())
        values = ", ".join(f"{value!r}" for value in member.values)
        lines += ["", "[[members]]", f"values = [{values}]", f"figures = {{{figures}}}"]
    write_text(path, "\n".join(lines) + "\n")


def _measure(context: Context) -> RobotEnsemble:
    """As many robots as there are seeds, drawn from the first; the file is written after each generation."""
    return design_ensemble(
        len(context.seeds),
        context.seeds[0],
        context.engine,
        f"python -m tests.measure ensemble --seeds {len(context.seeds)} --first-seed {context.seeds[0]} "
        f"--engine {context.engine}",
        lambda function, draws: context.campaign.map("robot", function, draws),
        lambda so_far: write_ensemble(context.out / "ensemble.toml", so_far),
    )


def _quantities(measured: Measured[RobotEnsemble]) -> dict[str, Any]:
    found = measured.results
    return {"tried": found.tried, "accepted": found.accepted, "members": len(found.members)}


ENSEMBLE: Final = Experiment(
    title="Robots that agree with the measurements of real ones",
    source="Population Monte Carlo: Beaumont et al. (2009). Ranges: emulator/wear/unknowns.toml.",
    measure=_measure,
    quantities=_quantities,
    claims=lambda measured: [
        bounded("As many as wanted", len(measured.results.members), len(measured.context.seeds), words="{}")
    ],
)
