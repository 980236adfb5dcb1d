"""The search over what the thesis leaves open: its points can be planned, its bounds hold what is shipped."""

from __future__ import annotations

import pytest

from bridge.body import load_body
from tests.measure.thesis_map import OPEN, SHIPPED, points, quantities
from walker.gaits import gait_parameters
from walker.gaits.thesis.dynamic.gait import DynamicGait
from walker.parameters import controller_parameters

V3 = load_body("nao-v3")


def test_every_point_can_be_planned_and_has_steps_of_its_length() -> None:
    for point in points()[1:]:
        changed = quantities(point, "dynamic").items()
        found = {name.removeprefix("parameters."): value for name, value in changed if "parameters" in name}
        dynamic = gait_parameters("dynamic", found)
        assert dynamic.periodic_step.length == pytest.approx(point["length"], abs=1e-6)
        assert DynamicGait(dynamic, V3).plan.length == pytest.approx(point["length"], abs=1e-6)


def test_the_shipped_point_is_within_the_bounds_and_changes_nothing() -> None:
    assert all(each.low <= each.shipped <= each.high for each in OPEN.values())
    assert quantities(SHIPPED, "dynamic") == quantities(SHIPPED, "static") == {}
    leg = controller_parameters("static", {}).leg
    assert (leg.D, leg.start) == (SHIPPED["D"], SHIPPED["start"])
