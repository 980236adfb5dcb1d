"""Conditions of the experiment `feedback`."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from bridge.errors import ConfigurationError
from nao_hil.experiments import feedback
from nao_hil.runs.campaign import Interrupted
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk
from tests.made_walks import MadeCampaign, made_context
from walker.parameters import controller_parameters
from walker.switches import differing


def test_each_condition_differs_from_the_shipped_one_in_one_switch_and_in_nothing_else(tmp_path: Path) -> None:
    campaign, changes = MadeCampaign(most=0), RunConfig(robot="nao-v6", engine="mujoco")
    context = made_context(campaign, tmp_path, (7,), changes)
    with pytest.raises(Interrupted):
        feedback.experiment(context)
    by_task: dict[str, dict[str, Walk]] = {}
    for walk in campaign.asked:
        _, task, condition = walk.name.split(", ")
        by_task.setdefault(task, {})[condition] = walk
    assert set(by_task) == {"push", "push in a stand", "plates", "slope", "worn", "straight"}
    for conditions in by_task.values():
        shipped = conditions.pop(feedback.SHIPPED)
        for name, walk in conditions.items():
            pair = (controller_parameters("omni", each.config.controller).switches for each in (shipped, walk))
            assert [f"without {switch}" for switch in differing(*pair)] == [name]
            config = msgspec.structs.replace(walk.config, controller=shipped.config.controller)
            assert msgspec.structs.replace(walk, name=shipped.name, config=config) == shipped


def test_a_gait_that_cannot_walk_as_fast_is_refused_before_the_first_walk(tmp_path: Path) -> None:
    campaign, changes = MadeCampaign(most=0), RunConfig(robot="nao-v3", engine="mujoco", gait="dynamic")
    context = made_context(campaign, tmp_path, (7,), changes, gait="dynamic")
    with pytest.raises(ConfigurationError, match=r"0.25 m/s are too fast for the dynamic gait on a nao-v3"):
        feedback.experiment(context)
    assert not campaign.asked
