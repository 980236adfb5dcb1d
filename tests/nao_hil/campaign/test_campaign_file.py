"""A campaign in a file, and the quantities it varies."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bridge.errors import ConfigurationError
from emulator.wear import load_wear
from nao_hil.campaigns.file import load_campaign
from nao_hil.campaigns.quantities import changed
from nao_hil.cli.main import run
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk

WALK = Walk(name="a", config=RunConfig(gait="static"), duration=1.0)
FILE = """
seeds = 3
first_seed = 5
duration = 0.2
[base]
engine = "mujoco"
gait = "static"
controller = { switches = { torso = "none" } }
[axes]
slope = [0, 2]
wear = ["ideal", "nominal"]
"""


def test_quantities_change_what_they_name_and_nothing_else() -> None:
    assert changed(WALK, "slope", 3.0).scenario.floor.pitch == -3.0  # uphill raises the front
    assert changed(WALK, "push", 2.0).scenario.pushes[0].impulse_vector() == (2.0, 0.0, 0.0)
    assert changed(WALK, "push", 0.0) == WALK
    assert changed(WALK, "friction", 0.3).scenario.floor.friction == 0.3
    assert changed(WALK, "controller.switches.torso", "none").config.controller == {
        "switches": {"torso": "none"}
    }
    assert changed(WALK, "controller.damping.roll", 0.1).config.controller == {"damping": {"roll": 0.1}}
    nominal, slow = load_wear("nominal"), changed(WALK, "delay", 0.05).wear
    assert slow is not None and slow.servo.delay == 0.05
    assert slow.sensors == nominal.sensors and slow.servo.backlash == nominal.servo.backlash
    loose = changed(WALK, "backlash", 2.0).wear
    assert loose is not None and loose.servo.backlash.KneePitch == 2.0 * nominal.servo.backlash.KneePitch


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("slop", 1.0, "slope"),
        ("scenario.floor.hight", 1.0, "hight"),
        ("wear.servo.delay", "long", "delay"),
        ("controller.switches.torsoo", "none", "torsoo"),
        ("parameters.unheard", 1.0, "unheard"),
        ("friction", -1.0, "friction"),
        ("gait.x", 1.0, "gait is no table"),
    ],
)
def test_a_quantity_that_is_none_is_one_sentence(name: str, value: object, sentence: str) -> None:
    with pytest.raises(ConfigurationError, match=sentence):
        changed(WALK, name, value)


def test_the_walks_of_a_file_are_all_combinations_with_all_seeds(tmp_path: Path) -> None:
    file = tmp_path / "slopes.toml"
    file.write_text(FILE)
    asked = load_campaign(file)
    cells = asked.cells()
    assert [point for point, _ in cells] == [
        {"slope": slope, "wear": wear} for slope in (0, 2) for wear in ("ideal", "nominal")
    ]
    walks = list(asked.walks(cells))
    assert [(w.scenario.floor.pitch, w.config.wear, w.config.seed) for w in walks[3:6]] == [
        (-2.0, "nominal", 5),
        (0.0, "ideal", 6),
        (0.0, "nominal", 6),
    ]
    assert len(walks) == 12


def test_a_campaign_counts_its_cells_and_goes_on_where_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "slopes.toml"
    file.write_text(FILE)
    command = ["campaign", str(file), "--out", str(tmp_path / "out"), "--cluster", "inline", "--json"]
    found = []
    for _ in range(2):
        assert run(command) == 0
        found.append(json.loads(capsys.readouterr().out.splitlines()[-1]))
    assert found[0] == found[1]
    assert found[0]["name"] == "slopes (only 3 of 20 seeds)"
    assert [(cell["n"], cell["survived"]) for cell in found[0]["cells"]] == [(3, 3)] * 4
    assert run(["results", "SELECT count(*) AS n FROM walks", str(tmp_path / "out"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["rows"] == [{"n": 12}]
