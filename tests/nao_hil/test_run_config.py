"""The configuration of a run, from options and files."""

from __future__ import annotations

from pathlib import Path

import pytest

from bridge.errors import ConfigurationError
from nao_hil.runs.build import clipped_velocity
from nao_hil.runs.config import RunConfig, run_config


def test_a_run_with_files_of_ones_own_can_be_run_again_from_another_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    config = run_config(None, robot="mine.toml", scenario="worlds/ice.toml", wear="nominal")
    assert config.robot == str(tmp_path / "mine.toml")
    assert config.scenario == str(tmp_path / "worlds" / "ice.toml")
    assert config.wear == "nominal"


def test_names_stay_names() -> None:
    config = run_config(None, robot="nao-v3.2")
    assert (config.robot, config.wear, config.scenario) == ("nao-v3.2", "nominal", "flat")


def test_a_velocity_has_three_numbers() -> None:
    assert run_config(None, velocity=(0.1, 0.0, -0.2)).velocity == (0.1, 0.0, -0.2)
    with pytest.raises(ConfigurationError, match="it takes three"):
        run_config(None, velocity=(0.1, 0.0))


def test_a_velocity_beyond_the_limits_of_the_gait_is_told() -> None:
    """Limit of 0.40 m/s forward (gait.toml)."""
    told = clipped_velocity(RunConfig(gait="omni", velocity=(5.0, 0.0, 0.0)))
    assert "5 m/s" in told and "0.4 m/s" in told
    assert not clipped_velocity(RunConfig(gait="omni", velocity=(0.2, 0.0, 0.0)))


def test_paths_in_a_file_are_relative_to_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine").mkdir()
    file = tmp_path / "mine" / "config.toml"
    file.write_text('scenario = "ice.toml"\nwear = "worn"\n')
    monkeypatch.chdir(tmp_path)
    config = run_config(file, robot="long.toml")
    assert config.scenario == str(tmp_path / "mine" / "ice.toml")
    assert (config.robot, config.wear) == (str(tmp_path / "long.toml"), "worn")
