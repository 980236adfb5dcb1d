"""The folder of a run: one run at a time, and a result with its configuration."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from bridge.errors import ConfigurationError
from nao_hil.runs.folder import RunDirectory


def test_a_folder_into_which_a_run_writes_is_refused_until_it_ends(tmp_path: Path) -> None:
    first, second = RunDirectory(tmp_path), RunDirectory(tmp_path)
    assert not first.clear()
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(
        ConfigurationError, match="a run that goes on writes into this folder; give another one"
    ):
        second.clear()
    assert (tmp_path / "summary.json").exists()
    first.release()
    assert second.clear() and not (tmp_path / "summary.json").exists()


def test_a_result_has_the_configuration_that_it_was_made_with(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "nao_hil.cli", "up", "--mode", "in-process", "--steps", "2", "--seed", "7"]
    command += ["--gait", "omni", "--engine", "mujoco", "--robot", "nao-v6", "--json", "--out", str(tmp_path)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    config = json.loads(ended.stdout)["config"]
    assert (config["robot"], config["seed"], config["gait"]) == ("nao-v6", 7, "omni")
    assert json.loads((tmp_path / "summary.json").read_text())["config"] == config
