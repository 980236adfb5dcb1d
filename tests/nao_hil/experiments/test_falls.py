"""Robots that are pushed, dropped and abused: the walk, the verdict, the energy."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from emulator.start import random_drop
from emulator.wear import load_wear
from nao_hil.experiments import falls
from nao_hil.experiments.context import Context
from nao_hil.experiments.falls import FALLS, FELLING, Fall, claims, judge
from nao_hil.experiments.get_up import DROP, WARM, dropped, get_up
from nao_hil.runs.build import build_robot
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from tests.emulator.abuse import run

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
        (fall,) = FALLS.run("falls", context).figures["falls"]
    assert fall.impulse == FELLING
    assert fall.walked == pytest.approx(10.0, abs=2.0)  # the rest is the approach to the stand
    assert fall.walks_on


def test_no_limb_of_a_dropped_robot_lies_inside_another() -> None:
    """The first pose of this seed has the feet 34 mm inside each other, which no real robot can have."""
    config = RunConfig(robot="nao-v6", engine="mujoco", seed=82270)
    with build_robot(config) as robot:
        robot.lay_down(random_drop(robot.body, DROP, np.random.default_rng([config.seed, 1])))
        assert robot.engine.overlap(robot.multibody, robot.multibody) > 0.03
    with dropped(config) as robot:
        assert robot.engine.overlap(robot.multibody, robot.multibody) < 1e-3


@pytest.mark.parametrize("seed", [88666, 88686], ids=["an arm under the torso", "limp on its feet, leaning"])
def test_a_difficult_drop_stands_up_with_cool_motors(seed: int) -> None:
    drop = get_up(RunConfig(robot="nao-v6", engine="mujoco", seed=seed)).drop
    assert drop.stands
    assert drop.temperature < WARM


BODY = load_body("nao-v3")


@pytest.mark.parametrize(("seed", "wear", "engine"), [(11, "nominal", "auto"), (12, "ideal", "mujoco")])
def test_the_robot_stays_a_physical_body_under_abuse(seed: int, wear: str, engine: str) -> None:
    result = run(10.0, seed=seed, body=BODY, wear=load_wear(wear), engine=engine)
    assert result["finite"]
    assert result["stop_excess_deg"] <= 1.0
    assert result["energy_rise_j"] <= 0.05
    assert result["falls"] > 0
    assert np.isfinite(result["farthest_m"]) and result["farthest_m"] < 10.0
