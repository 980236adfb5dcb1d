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


def test_the_camera_s_numbers_are_the_vendor_s() -> None:
    """As listed in `alvisiondefinitions.h` of the SDK."""
    numbers = module("vision_definitions")
    listed = {"SelectID": 18, "AutoGainID": 13, "FrameRateID": 15, "WhiteBalanceID": 33, "AutoFocusID": 40}
    assert {name: getattr(numbers, f"kCamera{name}") for name in listed} == listed
    assert (numbers.kHSMixedColorSpace, numbers.kRawDepthColorSpace) == (16, 23)


def test_static_methods_have_the_flat_names_of_the_vendor_s_wrapper() -> None:
    """As the vendor's sample of landmarks uses them."""
    almath = module("almath")
    turned = almath.Transform_from3DRotation(0.0, 0.0, math.pi / 2.0) * almath.Transform(0.5, 0.0, 0.0)
    assert (turned.r1_c4, turned.r2_c4, turned.r3_c4) == pytest.approx((0.0, 0.5, 0.0), abs=1e-9)


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


def test_a_step_is_clipped_to_an_ellipse_in_its_direction() -> None:
    almath = module("almath")
    step = almath.Pose2D(0.08, 0.06, 0.1)
    assert almath.clipFootWithEllipse(0.05, 0.05, step) is True
    assert step.toVector() == pytest.approx([0.04, 0.03, 0.1])
    assert almath.clipFootWithEllipse(-0.05, 0.05, step) is False
