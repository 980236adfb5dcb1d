"""The command line: configuration shown and checked, completion, suggestions, one JSON object at the end."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from bridge.recording import Recorder
from lab.cli.main import run
from lab.config import RunConfig, run_config

REPOSITORY = Path(__file__).parents[2]


def shown(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert run(list(arguments)) == 0
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The sentence of a command that a user got wrong."""
    assert run(list(arguments)) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    return said[0]


def test_what_config_shows_config_takes_back(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    options = ("--gait", "dynamic", "--torso", "thesis", "--wear", "worn", "--seed", "7")
    file = tmp_path / "my.toml"
    file.write_text(shown(capsys, "config", "show", *options))
    config = run_config(file)
    assert (config.gait, config.wear, config.seed, config.controller["torso"]) == (
        "dynamic",
        "worn",
        7,
        "thesis",
    )
    assert config.parameters["e_s1"] == 0.03  # figure 3.6
    assert shown(capsys, "config", "show", "--config", str(file)) == file.read_text()
    assert json.loads(shown(capsys, "config", "check", str(file), "--json"))["kind"] == "run"


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("emulator/scenarios/pushes.toml", "scenario"),
        ("emulator/wear/worn.toml", "wear"),
        ("bridge/datasheet/bodies/nao-v6.toml", "body"),
    ],
)
def test_a_file_is_known_by_its_keys(capsys: pytest.CaptureFixture[str], path: str, kind: str) -> None:
    result = json.loads(shown(capsys, "config", "check", str(REPOSITORY / path), "--json"))
    assert (result["kind"], result["ok"]) == (kind, True)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('gait = "statc"', "did you mean 'static'"),
        ("[parameters]\nl_lft = 0.03", "did you mean 'l_lift'"),
        ("[controller]\ntorzo = 'none'", "did you mean 'torso'"),
        ("stps = 4\nseed = 1", "unknown key 'stps', did you mean 'steps'"),
        ("[parameters]\nl_SW = 0.12", "out of reach"),
        ("wear = 'wron'", "did you mean 'worn'"),
        ("colour = 'red'", "say what it is with --kind"),
        ("steps = ", "not valid TOML"),
    ],
)
def test_a_wrong_file_is_told_in_one_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, says: str
) -> None:
    (tmp_path / "wrong.toml").write_text(text)
    assert says in refused(capsys, "config", "check", str(tmp_path / "wrong.toml"))


def test_a_misspelt_command_or_option_is_told_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert "plot" in refused(capsys, "plt")
    assert "--steps" in refused(capsys, "up", "--stps", "3")
    assert "did you mean 'torso'" in refused(capsys, "plot", "x.mcap", "--what", "torzo")


def test_info_ends_with_one_json_object(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with Recorder(tmp_path / "empty.mcap", RunConfig(seed=9)):
        pass
    contents = json.loads(shown(capsys, "info", str(tmp_path / "empty.mcap"), "--json"))
    assert contents["complete"]
    assert contents["config"]["seed"] == 9
    assert contents["cycles"] == 0
    whole = (tmp_path / "empty.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[:-20])
    assert not json.loads(shown(capsys, "info", str(tmp_path / "cut.mcap"), "--json"))["complete"]


@pytest.mark.parametrize(
    ("typed", "offers"),
    [
        ("nao-hil re", {"record", "replay"}),
        ("nao-hil up --gait st", {"static"}),
        ("nao-hil up --scenario slope-", {"slope-5", "slope-down-5", "slope-side-5"}),
        ("nao-hil plot x.mcap --what torso,ce", {"torso,cells"}),
    ],
)
def test_the_shell_completes_names(typed: str, offers: set[str]) -> None:
    environment = os.environ | {
        "_NAO_HIL_COMPLETE": "complete_bash",
        "COMP_WORDS": typed,
        "COMP_CWORD": str(len(typed.split(" ")) - 1),
    }
    script = "import sys; sys.argv = ['nao-hil']; from lab.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=environment,
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert set(done.stdout.split()) == offers


def test_help_and_completion_load_no_library_of_one_command() -> None:
    """Nor PyBullet, which the walker's machine does not have."""
    heavy = ["pybullet", "matplotlib", "viser", "qi", "optuna", "control", "cryptography"]
    script = f"import sys, lab.cli.main; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=REPOSITORY, capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"
