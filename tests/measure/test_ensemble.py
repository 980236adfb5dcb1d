"""Drawing of an ensemble, against a robot whose figures are known functions of its unknowns."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from bridge.config import load_toml
from emulator.wear.ensemble import RobotEnsemble, load_ensemble, unknowns
from tests.measure.ensemble import (
    COMPARED,
    Draw,
    Sampler,
    Trial,
    design_ensemble,
    distance,
    try_robot,
    write_ensemble,
)

CENTRES = {name: 0.5 * (low + high) for name, (low, high) in COMPARED.items()}


def made_up(draw: Draw) -> Trial:
    """Natural frequency by the loop alone, 4 to 10 rad/s; 5.95 to 8.05 agree, 35 % of the range."""
    figures = CENTRES | {"natural_frequency_rad_s": 4.0 + 6.0 * unknowns()["loop"].share(draw.values["loop"])}
    return Trial(figures, distance(figures))


def spread(function: object, draws: Sequence[Draw]) -> list[Trial]:
    return [made_up(draw) for draw in draws]


def designed(seed: int, members: int = 40) -> RobotEnsemble:
    return design_ensemble(members, seed, "mujoco", "test", spread, lambda _: None)


def test_members_are_those_that_agree() -> None:
    ensemble = designed(1)
    place = ensemble.unknowns.index("loop")
    shares = [unknowns()["loop"].share(member.values[place]) for member in ensemble.members]
    assert len(ensemble.members) == 40
    assert min(shares) >= 0.325 - 1e-3 and max(shares) <= 0.675 + 1e-3


def test_weights_make_draws_around_the_best_even_again() -> None:
    """In one dimension, with kernels at 0.3: the weighted mean of all draws is that of an even distribution."""
    sampler = Sampler(1, np.random.default_rng(0))
    sampler.first(400)
    random = np.random.default_rng(1)
    for _ in range(4):
        sampler.around(0.3 + 0.05 * random.standard_normal((12, 1)), 100)
    # inside the range, away from the cut ends
    inside = sampler.shares[(sampler.shares[:, 0] > 0.05) & (sampler.shares[:, 0] < 0.95)]
    assert float(inside.mean()) < 0.45
    assert float(sampler.weights(inside) @ inside[:, 0]) == pytest.approx(0.5, abs=0.03)


def test_the_same_seed_draws_the_same_robots_and_the_file_keeps_them(tmp_path: Path) -> None:
    once, again, other = designed(3, 5), designed(3, 5), designed(4, 5)
    assert once == again and once.members != other.members
    write_ensemble(tmp_path / "e.toml", once)
    kept = load_toml(tmp_path / "e.toml", RobotEnsemble)
    assert [m.values for m in kept.members] == [m.values for m in once.members]


def test_a_stopped_design_keeps_its_members() -> None:
    kept: list[RobotEnsemble] = []
    found = design_ensemble(60, 1, "mujoco", "test", lambda f, d: spread(f, d)[:7], kept.append)
    assert found.tried == 7 and kept[-1] == found


def test_a_members_figures_are_those_of_the_file() -> None:
    ensemble = load_ensemble()
    values = dict(zip(ensemble.unknowns, ensemble.members[0].values, strict=True))
    trial = try_robot(Draw(values, ensemble.engine))
    # not to the bit: processors round differently, and the tracking errors depend on the gait that walks
    assert trial.figures == pytest.approx(ensemble.members[0].figures, rel=0.10)
