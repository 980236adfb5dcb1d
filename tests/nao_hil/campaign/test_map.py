"""Maps: a known boundary is found with few walks, and the command."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from bridge.errors import ConfigurationError
from nao_hil.campaigns.map import Cell, Survey, parse_axis
from nao_hil.cli.main import run

SIZE = 20


def chance(cell: Cell, width: float) -> float:
    """Of a walk on: a logistic slope across a quarter circle of radius 12 cells."""
    return 1.0 / (1.0 + math.exp((math.hypot(*cell) - 12.0) / width))


@pytest.mark.parametrize("seed", range(5))
def test_a_boundary_is_found_within_a_cell_by_less_than_a_quarter_of_the_walks(seed: int) -> None:
    generator, most = np.random.default_rng(seed), 20

    def attempt(asked: Sequence[tuple[Cell, int]]) -> list[bool]:
        return [bool(generator.random() < chance(cell, 0.4)) for cell, _ in asked]

    found = Survey((SIZE, SIZE))
    found.run(attempt)
    assert sum(found.tried.values()) < 0.25 * SIZE * SIZE * most
    wrong = [
        cell
        for cell in np.ndindex(SIZE, SIZE)
        if (found.shares()[cell] >= 0.5) != (chance(cell, 0.4) >= 0.5)  # type: ignore[arg-type]
    ]
    assert all(abs(math.hypot(*cell) - 12.0) <= 1.0 for cell in wrong)


@pytest.mark.parametrize("text", ["push", "push=3:1", "push=0:1:1", "push=a:b", "=0:1"])
def test_an_axis_that_is_none_is_one_sentence(text: str) -> None:
    with pytest.raises(ConfigurationError, match="must be NAME=LOW:HIGH"):
        parse_axis(text)


def test_a_map_of_walks_has_a_picture_and_goes_on_where_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    axes = ["slope=0:30:2", "friction=0.7:0.8:2"]
    walk = ["--engine", "mujoco", "--gait", "static", "--duration", "0.3", "--seeds", "4"]
    command = ["map", *axes, *walk, "--cluster", "inline", "--out", str(tmp_path), "--json"]
    found = []
    for _ in range(2):
        assert run(command) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert found[0] == found[1]
    assert {cell["x"]: cell["survived"] for cell in found[0]["cells"]} == {0.0: 4, 30.0: 0}
    assert found[0]["walks"] == found[0]["full_grid"] == 16
    assert (tmp_path / "map.png").stat().st_size > 5000
