"""The walks of the map: conditions differ in the one mechanism that the experiment is about."""

from pathlib import Path

import pytest

from nao_hil.experiments.context import Context
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from tests.measure.thesis_map import points, walks
from walker.parameters import controller_parameters
from walker.switches import differing


@pytest.mark.parametrize(
    ("experiment", "switch"),
    [("R1", "leg_admittance"), ("R2", "torso"), ("R5", "torso"), ("R5, search", "torso")],
)
def test_conditions_of_a_point_differ_in_one_switch(experiment: str, switch: str, tmp_path: Path) -> None:
    context = Context(Campaign(), tmp_path, (1, 2), RunConfig(engine="mujoco"))
    point = points()[1]
    with_, without = (walks(context, experiment, point, condition) for condition in ("with", "without"))
    assert [walk.config.seed for walk in with_] == [1, 2]
    assert all(bool(walk.world_events) == (experiment == "R1") for walk in (*with_, *without))
    for one, other in zip(with_, without, strict=True):
        controllers = [controller_parameters(w.config.gait, w.config.controller) for w in (one, other)]
        assert [c.leg.D for c in controllers] == [point["D"]] * 2
        assert differing(*(c.switches for c in controllers)) == [switch]
