"""The vendor's Python modules that programs import."""

from __future__ import annotations

import importlib.util
import math
from importlib.machinery import FileFinder
from pathlib import Path
from typing import Any

import pytest

from nao_hil.naoqi_programs.loading import ProgramLoader
from nao_hil.naoqi_programs.runner import MODULES
from tests.processes import module_of


def module(name: str) -> Any:
    return module_of(MODULES / f"{name}.py")


def test_a_module_beside_a_program_may_be_in_python_2(tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text("print 'imported'\nhalf = 7 / 2\n")
    spec = FileFinder(str(tmp_path), (ProgramLoader, [".py"])).find_spec("beside")
    assert spec is not None and spec.loader is not None
    made: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    assert made.half == 3


@pytest.mark.parametrize("goal", [(0.0, -0.4, 0.0), (0.5, 0.3, 1.0), (-0.5, 0.3, -2.0), (1.0, 0.0, 0.0)])
def test_a_dubins_way_is_an_arc_a_line_and_an_arc(goal: tuple[float, float, float]) -> None:
    """Both arcs begin along x: their ends are on a circle of the radius, along its tangent."""
    almath, radius = module("almath"), 0.05
    first, second, end = almath.getDubinsSolutions(almath.Pose2D(*goal), radius)
    for arc in (first, second.inverse() * end):
        assert math.hypot(arc.x, abs(arc.y) - radius) == pytest.approx(radius)
        assert math.cos(arc.theta) == pytest.approx(1.0 - abs(arc.y) / radius)
    line = first.inverse() * second
    assert line.toVector() == pytest.approx([math.hypot(line.x, line.y), 0.0, 0.0], abs=1e-9)
    assert end.toVector() == list(goal)


def test_a_foot_turns_in_until_it_touches_the_other_one() -> None:
    """Feet as in the vendor's sample. The front corner of the right foot, 9 cm aside and turned in by t, is at
    -0.09 + 0.11 sin t + 0.038 cos t; the edge of the left one is at -0.038: they touch from 0.1306 rad on."""
    almath = module("almath")
    left = almath.vectorPosition2D(
        [almath.Position2D(x, y) for x, y in ((0.11, 0.05), (0.11, -0.038), (-0.047, -0.038), (-0.047, 0.05))]
    )
    right = almath.vectorPosition2D()
    for x, y in ((0.11, 0.038), (0.11, -0.05), (-0.047, -0.05), (-0.047, 0.038)):
        right.push_back(almath.Position2D(x, y))
    step = almath.Pose2D(0.0, -0.09, 0.3)
    assert almath.avoidFootCollision(left, right, True, step) is True
    assert 0.1306 - 0.3 / 32.0 <= step.theta <= 0.1306 and (step.x, step.y) == (0.0, -0.09)
    assert almath.avoidFootCollision(left, right, True, almath.Pose2D(0.0, -0.09, 0.12)) is False
    other = almath.Pose2D(0.0, 0.09, -0.3)  # the left foot beside the right one: the mirror image
    assert almath.avoidFootCollision(left, right, False, other) is True
    assert other.theta == pytest.approx(-step.theta)
