"""Screening and indices against functions whose effects and variances are known in closed form."""

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from emulator.wear.ensemble import unknowns
from nao_hil.experiments.context import Context
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from tests.measure import sensitivity
from tests.measure.sensitivity import (
    FIGURES,
    LEVELS,
    SENSITIVITY,
    elementary_effects,
    sobol_indices,
    trajectory,
)

NAMES = tuple(unknowns())


def test_a_trajectory_moves_each_unknown_once_on_the_grid() -> None:
    points = trajectory(9, np.random.default_rng(3))
    moves = np.diff(points, axis=0)
    assert points.shape == (10, 9)
    np.testing.assert_allclose(points * (LEVELS - 1), np.round(points * (LEVELS - 1)), atol=1e-12)
    assert points.min() >= 0.0 and points.max() <= 1.0
    assert (np.count_nonzero(moves, axis=1) == 1).all() and (np.count_nonzero(moves, axis=0) == 1).all()
    np.testing.assert_allclose(np.abs(moves).sum(axis=0), 2.0 / 3.0)


def test_elementary_effects_of_a_linear_function_are_its_coefficients() -> None:
    coefficients = np.random.default_rng(0).normal(size=(9, 2))
    points = trajectory(9, np.random.default_rng(1))
    np.testing.assert_allclose(elementary_effects(points, points @ coefficients), coefficients, atol=1e-12)


def test_the_strongest_unknowns_are_found_with_their_shares_of_the_variance(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """y = 3 loop + 4 delay: effects 3 and 4, shares of the variance 9/25 and 16/25."""

    def figures(_: Any, robots: Sequence[dict[str, float]], __: Any) -> np.ndarray:
        y = [3.0 * robot.get("loop", 0.5) + 4.0 * robot.get("delay", 0.5) for robot in robots]
        return np.repeat(np.array(y)[:, None], len(FIGURES), axis=1)

    monkeypatch.setattr(sensitivity, "_figures", figures)
    with Campaign(cluster="inline", stop=threading.Event()) as campaign:
        outcome = SENSITIVITY.run("sensitivity", Context(campaign, tmp_path, tuple(range(8)), RunConfig()))
    result = outcome.figures
    effects, indices = result["effects"]["damping"], result["indices"]["damping"]
    assert effects["loop"].mean == pytest.approx(3.0) and effects["delay"].mean == pytest.approx(4.0)
    assert effects["loop"].spread == pytest.approx(0.0, abs=1e-9)
    assert all(effects[name].mean < 1e-9 for name in NAMES if name not in ("loop", "delay"))
    assert result["decide"]["damping"] == ["delay", "loop"]
    assert indices["loop"].first == pytest.approx(9.0 / 25.0, abs=0.1)
    assert indices["delay"].total == pytest.approx(16.0 / 25.0, abs=0.1)
    assert len(outcome.page.tables[0].rows) == len(NAMES)


@pytest.mark.filterwarnings("error")
def test_a_constant_figure_has_no_indices() -> None:
    first, total = sobol_indices(np.full((4, 8), 10.0))
    assert np.isnan(first).all() and np.isnan(total).all()
