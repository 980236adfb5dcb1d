"""The folder of a run: one run at a time, and a result with its configuration."""

import json
from pathlib import Path

import pytest

import bridge.body
import emulator.wear
from bridge.errors import ConfigurationError
from nao_hil.cli.main import run
from nao_hil.runs.config import RunConfig
from nao_hil.runs.folder import RunDirectory
from nao_hil.runs.run import load
from tests.ports import free_endpoint

Output = pytest.CaptureFixture[str]


def up(capsys: Output, *options: str) -> tuple[int, str, str]:
    """`nao-hil up --json` in this process: its exit code, and what it says on stdout and stderr."""
    code = run(["up", "--engine", "mujoco", "--json", *options])
    said = capsys.readouterr()
    return code, said.out, said.err


def test_a_folder_into_which_a_run_writes_is_refused_until_it_ends(tmp_path: Path) -> None:
    first, second = RunDirectory(tmp_path), RunDirectory(tmp_path)
    first.clear(overwrite=False)
    for name in ("summary.json", "frames-2.mcap", "notes.txt"):
        (tmp_path / name).write_text("{}")
    with pytest.raises(
        ConfigurationError, match="a run that goes on writes into this folder; give another one"
    ):
        second.clear(overwrite=True)
    assert (tmp_path / "summary.json").exists()
    first.release()
    with pytest.raises(ConfigurationError, match=r"holds a run already \(summary\.json\).*--overwrite"):
        second.clear(overwrite=False)
    assert (tmp_path / "summary.json").exists()
    second.clear(overwrite=True)
    assert [path.name for path in tmp_path.iterdir() if path.suffix != ".lock"] == ["notes.txt"]


@pytest.mark.parametrize("mode", ["in-process", "lockstep"])
def test_a_run_replaces_an_earlier_one_only_when_it_is_told_to(
    tmp_path: Path, mode: str, capsys: Output
) -> None:
    options = ["--mode", mode, "--steps", "2", "--gait", "dynamic", "--out", str(tmp_path)]
    options += ["--listen", free_endpoint(), "--seed", "2"]
    (tmp_path / "summary.json").write_text("{}")
    code, _, error = up(capsys, *options)
    assert code == 2
    assert "holds a run already" in error and "--overwrite" in error
    assert [path.read_text() for path in tmp_path.iterdir()] == ["{}"]
    code, result, _ = up(capsys, *options, "--overwrite")
    assert code == 0
    assert json.loads(result)["seed"] == json.loads((tmp_path / "summary.json").read_text())["seed"] == 2


def test_a_run_is_repeated_by_its_folder_when_its_files_have_changed_and_the_folder_has_moved(
    tmp_path: Path, capsys: Output
) -> None:
    sheet, wear, ground = (tmp_path / name for name in ("sheet.toml", "knees.toml", "tiles.toml"))
    sheet.write_text((Path(bridge.body.__file__).parent / "bodies" / "nao-v6.toml").read_text("utf-8"), "utf-8")
    wear.write_text((Path(emulator.wear.__file__).parent / "worn.toml").read_text("utf-8"), "utf-8")
    ground.write_text("[floor]\nroll = 2\n")
    options = ["--robot", str(sheet), "--wear", str(wear), "--scenario", str(ground), "--gait", "omni"]
    options += ["--mode", "in-process", "--duration", "1", "--out", str(tmp_path / "a")]
    _, first, _ = up(capsys, *options)
    ground.write_text("[floor]\nroll = 0\n")
    wear.unlink()
    sheet.unlink()
    (tmp_path / "a").rename(tmp_path / "b")
    _, second, _ = up(capsys, "--config", str(tmp_path / "b" / "config.toml"), "--out", str(tmp_path / "c"))
    assert json.loads(first)["frames_sha256"] == json.loads(second)["frames_sha256"]
    title = "sheet.toml, wear knees.toml, gait omni, seed 0"  # no folders
    assert load(tmp_path / "b" / "frames.mcap").title == title


@pytest.mark.parametrize("field", ["robot", "wear", "scenario"])
def test_a_configuration_with_a_file_that_is_not_there_is_refused(tmp_path: Path, field: str) -> None:
    config = RunConfig(**{field: str(tmp_path / "missing.toml")})
    with pytest.raises(ConfigurationError, match=r"missing\.toml: cannot be read"):
        RunDirectory(tmp_path).write_config(config)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("mode", ["in-process", "lockstep"])
def test_a_robot_that_falls_before_the_run_begins_is_refused(tmp_path: Path, mode: str, capsys: Output) -> None:
    (tmp_path / "steep.toml").write_text("[floor]\npitch = 25\n")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "summary.json").write_text("{}")
    options = ["--robot", "nao-v3", "--scenario", str(tmp_path / "steep.toml"), "--mode", mode, "--steps", "2"]
    code, _, error = up(capsys, *options, "--listen", free_endpoint(), "--out", str(tmp_path / "run"))
    assert code == 2
    (sentence,) = [line for line in error.splitlines() if "falls before the run begins" in line]
    assert "flatter floor" in sentence and "Traceback" not in error
    assert (tmp_path / "run" / "summary.json").exists()  # the run that was there stays


def test_the_folder_of_a_world_names_the_folders_of_its_robots(tmp_path: Path) -> None:
    for name in ("red", "blue"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "frames.mcap").touch()
    with pytest.raises(ConfigurationError, match=r"run of a world.*blue, red; give .*/blue"):
        load(tmp_path)
