"""Falls: what counts as foreseen, and a walk that is pushed."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from bridge.errors import ConfigurationError
from nao_hil.experiments import falls
from nao_hil.experiments.context import Context
from nao_hil.experiments.falls import FELLING, Fall, claims, experiment, judge, pushes
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig

STOOD = Fall(
    seed=0, impulse=1.0, walked=5.0, false_alarms=0, fell=False, lead=0.0, tilt=0.0, speed={}, walks_on=True
)
FELL = msgspec.structs.replace(STOOD, fell=True, lead=0.25, tilt=12.0, speed={"Torso": 1.5})


def test_every_fall_must_be_foreseen_in_time_softly_and_without_alarms() -> None:
    falls = [FELL] * 60 + [STOOD] * 40
    found = judge(falls)
    assert (found["fell"], found["foreseen"], found["walked_s"]) == (60, 60, 500.0)
    assert all(claim.holds for claim in claims(found))
    for flaw in ({"lead": 0.1}, {"tilt": 25.0}, {"speed": {"HeadPitch": 2.3}}, {"walks_on": False}):
        spoilt = [msgspec.structs.replace(each, **flaw) for each in falls[:10]]
        assert not all(claim.holds for claim in claims(judge([*spoilt, *falls[10:]]))), flaw
    alarmed = judge([msgspec.structs.replace(STOOD, false_alarms=1), *falls])
    assert not all(claim.holds for claim in claims(alarmed))


def test_a_push_in_each_part_of_a_long_walk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(falls, "PUSH_PERIOD", 12.0)
    changes = RunConfig(robot="nao-v6", engine="mujoco", gait="omni")
    with Campaign(cluster="inline") as campaign:
        context = Context(campaign, tmp_path, (3,), changes, duration=12.0)
        (fall,) = experiment(context).figures["falls"]
    assert fall.impulse == FELLING
    assert fall.walked == pytest.approx(10.0, abs=2.0)  # the rest is the approach to the stand
    assert fall.walks_on


def test_a_walk_too_short_for_a_push_is_refused_with_the_shortest() -> None:
    with pytest.raises(ConfigurationError, match="at least 60 s"):
        pushes(30.0)
    assert [pushes(60.0), pushes(600.0)] == [1, 10]
