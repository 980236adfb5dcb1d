"""The configuration of a run, from options and files; numbers in another unit than the file's."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import bridge.body
import emulator.wear
from bridge.errors import ConfigurationError
from nao_hil.cli.config import KINDS, kind_of
from nao_hil.runs.build import check_run, configuration_warnings
from nao_hil.runs.config import RunConfig, run_config


def test_a_walk_of_a_robot_that_hangs_is_refused() -> None:
    hangs = RunConfig(start="hang", engine="mujoco")
    check_run(hangs)  # for a walker that waits for orders
    with pytest.raises(ConfigurationError, match="hangs"):
        check_run(hangs, waits=False)


def test_paths_in_a_file_are_relative_to_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine").mkdir()
    file = tmp_path / "mine" / "config.toml"
    file.write_text('scenario = "ice.toml"\nwear = "worn"\n')
    monkeypatch.chdir(tmp_path)
    config = run_config(file, robot="long.toml")
    assert config.scenario == str(tmp_path / "mine" / "ice.toml")
    assert (config.robot, config.wear) == (str(tmp_path / "long.toml"), "worn")


BODY = (Path(bridge.body.__file__).parent / "bodies" / "nao-v6.toml").read_text()
WEAR = (Path(emulator.wear.__file__).parent / "nominal.toml").read_text()


@pytest.mark.parametrize(
    ("text", "pattern", "replacement", "named"),
    [
        (BODY, r"^cycle = .*", "cycle = 12.0", "cycle"),
        (BODY, r"ThighLength = [\d.]+", "ThighLength = 100.0", "lengths.ThighLength"),
        (BODY, r"LKneePitch = { lower = [-\d.]+", "LKneePitch = { lower = -15.3", "joints.LKneePitch.lower"),
        (BODY, r"mass = [\d.]+", "mass = 1049.0", "mass"),
        (WEAR, r"delay = [\d.]+", "delay = 30.0", "servo.delay"),
        (WEAR, r"^KneePitch = [\d.]+", "KneePitch = 1.4", "servo.backlash.KneePitch"),
    ],
)
def test_a_wrong_unit_is_named_with_the_number(
    tmp_path: Path, text: str, pattern: str, replacement: str, named: str
) -> None:
    file = tmp_path / "file.toml"
    changed, n = re.subn(pattern, replacement, text, count=1, flags=re.MULTILINE)
    assert n == 1
    file.write_text(changed)
    got = re.escape(replacement.split("= ")[-1])
    with pytest.raises(ConfigurationError, match=re.escape(named) + ".*expected a number [<>]= .*, got " + got):
        KINDS[kind_of(file)][1](file)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[tiles]\narea = [200, 200]\nedge = 0.01\nheight = 0.01\n", "400000000 tiles; at most 10000"),
        ("[heightfield]\nroughness = 0.005\narea = [100, 100]\nspacing = 0.005\n", "points; at most 250000"),
    ],
)
def test_a_ground_that_no_engine_can_lay_is_refused(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "file.toml"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=words):
        KINDS["scenario"][1](file)


@pytest.mark.parametrize(
    ("gait", "changes", "word"),
    [
        ("omni", {"velocity": (2.0, 0.0, 0.0)}, "0.4 m/s"),
        ("omni", {"controller": {"switches": {"leg_admittance": True}}}, "admittances"),
        ("omni", {"controller": {"switches": {"ankle_admittance": True}}}, "admittances"),
        ("static", {"controller": {"switches": {"leg_admittance": True}}}, None),  # its own
        ("omni", {"velocity": (0.2, 0.0, 0.0)}, None),
    ],
)
def test_a_run_that_goes_otherwise_than_its_user_may_expect_says_so(
    gait: str, changes: dict[str, Any], word: str | None
) -> None:
    said = configuration_warnings(RunConfig(gait=gait, **changes))
    assert len(said) == (word is not None)
    assert all(str(word) in sentence for sentence in said)
