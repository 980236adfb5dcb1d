"""A campaign in a file, and the quantities it varies."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bridge.config import from_dict
from bridge.errors import ConfigurationError
from emulator.wear import load_wear
from nao_hil.campaigns.comparisons import comparisons
from nao_hil.campaigns.file import CampaignCell, CampaignFile, load_campaign
from nao_hil.campaigns.quantities import changed
from nao_hil.cli.main import run
from nao_hil.runs.build import with_engine
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk
from tests.made_walks import walk_end

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
    (other,) = changed(WALK, "neighbours", [{"at": [1.0, 0.0], "yaw": 180.0}]).neighbours
    assert other.at == (1.0, 0.0) and other.yaw == 180.0 and other.velocity is None
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
        ("slope", "a", "slope: expected a number, got text"),
        ("push", [1.0], "push: expected a number"),
        ("backlash", "a", "backlash: expected a number, got text"),
        ("duration", "a", "duration: expected a number, got text"),
        ("duration", -1.0, "duration: expected a number > 0"),
        ("scenario", 3, "scenario: expected text, got a whole number"),
        ("neighbours", [{"yaw": 90.0}], "neighbours.*at"),
        ("neighbours", [{"at": [1.0, 0.0], "gait": "omnii"}], "neighbours.*gait.*omni"),
        ("neighbours", [{"at": [1.0, 0.0], "robot": "nao-v9"}], "neighbours.*body.*nao-v6"),
        ("neighbours", [{"at": [1.0, 0.0], "wear": "mine.toml"}], "neighbours.*wear"),
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
    file.write_text(FILE.replace("slope = [0, 2]", "slope = [2, 2.0]"))
    with pytest.raises(ConfigurationError, match="slope has a value twice"):
        load_campaign(file).cells()
    file.write_text("seeds = 3")
    with pytest.raises(ConfigurationError, match="no tables `base` and `axes`"):
        load_campaign(file)


def test_a_campaign_counts_its_cells_and_goes_on_where_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "slopes.toml"
    file.write_text(FILE.replace("seeds = 3", "seeds = 1"))
    command = ["campaign", str(file), "--out", str(tmp_path / "out"), "--cluster", "inline", "--json"]
    found = []
    for _ in range(2):
        assert run(command) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert found[0] == found[1]
    assert found[0]["name"] == "slopes (only 1 of 20 seeds)"
    config = found[0]["config"]
    assert (config["first_seed"], config["seeds"], config["axes"]["slope"]) == (5, 1, [0, 2])
    again = from_dict(config, "config", CampaignFile)
    same = [(point, with_engine(walk.config)) for point, walk in load_campaign(file).cells()]
    assert [(point, walk.config) for point, walk in again.cells()] == same
    assert [(cell["n"], cell["survived"]) for cell in found[0]["cells"]] == [(1, 1)] * 4
    compared = [(c["quantity"], c["value"], c["against"], c["at"]) for c in found[0]["comparisons"]]
    assert compared == [
        ("wear", "nominal", "ideal", {"slope": 0}),
        ("slope", 2, 0, {"wear": "ideal"}),
        ("slope", 2, 0, {"wear": "nominal"}),
        ("wear", "nominal", "ideal", {"slope": 2}),
    ]
    assert [c["survived"]["both"] for c in found[0]["comparisons"]] == [1] * 4
    assert run([*command[:-1]]) == 0
    assert "In pairs, on the same seeds" in capsys.readouterr().out
    assert run(["results", "SELECT count(*) AS n FROM walks", str(tmp_path / "out"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rows"] == [{"n": 4}]


def cell(value: int, survived: dict[int, bool], speed: float) -> CampaignCell:
    made = CampaignCell({"slope": value})
    for seed, alive in survived.items():
        made.ends[seed] = walk_end("walked" if alive else "fell", 10.0, distance=10.0 * speed + 0.1 * seed)
    return made


def test_cells_are_compared_on_common_seeds_alone() -> None:
    """Six seeds that only the first cell walks on: p = 2 / 2^6, by Holm for two comparisons twice that."""
    first = cell(0, dict.fromkeys(range(8), True), 0.3)
    second = cell(2, {seed: seed > 6 for seed in range(1, 10)}, 0.2)
    alone = cell(4, {20: True}, 0.2)
    third = cell(6, dict.fromkeys(range(4), True), 0.35)
    found = comparisons([first, second, alone, third])
    assert [(each.value, each.survived.n) for each in found] == [(2, 7), (6, 4)]
    assert (found[0].survived.only_with, found[0].survived.only_without) == (0, 6)
    assert found[0].survived.p_value == pytest.approx(2.0 / 2**6)
    assert found[0].p_value == pytest.approx(4.0 / 2**6) and found[1].p_value == 1.0
    assert found[0].speed.n == 1 and found[0].speed.value == pytest.approx(-0.1)
    assert found[1].speed.value == pytest.approx(0.05)


def test_a_cell_that_cannot_be_walked_is_named_and_the_others_count(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "shins.toml"
    file.write_text(
        'seeds = 2\nduration = 0.1\n[base]\nengine = "mujoco"\ngait = "static"\n'
        '[axes]\n"body.lengths.TibiaLength" = [0.1, 0.06]\n'
    )
    assert run(["campaign", str(file), "--out", str(tmp_path / "out"), "--cluster", "inline", "--json"]) == 2
    said = capsys.readouterr()
    found = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert [cell["n"] for cell in found["cells"]] == [2, 0]
    assert "body.lengths.TibiaLength 0.06 (seed 0): " in found["error"]
    assert "TibiaLength 0.06" in said.err
