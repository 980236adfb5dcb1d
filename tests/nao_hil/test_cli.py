"""The command line: configuration shown and checked, completion, suggestions, one JSON object at the end."""

from __future__ import annotations

import json
import re
import shlex
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from bridge.body import load_body
from bridge.messages.world import Push
from bridge.recording.recorder import Recorder
from emulator.robot import EmulatedRobot
from nao_hil.cli.main import run
from nao_hil.runs.config import RunConfig, run_config
from tests.loops import TIMEOUT, repeat_while
from tests.ports import free_endpoint
from tests.processes import REPOSITORY


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
    assert (config.gait, config.wear, config.seed, config.controller["switches"]["torso"]) == (
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
        ("bridge/body/bodies/nao-v6.toml", "body"),
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
        ("[controller.switches]\ntorzo = 'none'", "did you mean 'torso'"),
        ("stps = 4\nseed = 1", "unknown key 'stps' (did you mean 'steps'?)"),
        ("gait = 'static'\n[parameters]\nl_SW = 0.12", "out of reach"),
        ("gait = 'dynamic'\nvelocity = [0.5, 0.0, 0.0]", "0.5 m/s are too fast for the dynamic gait"),
        ("wear = 'wron'", "did you mean 'worn'"),
        ("[parametrs]\nl_lift = 0.03", "unknown key 'parametrs' (did you mean 'parameters'?)"),
        ("colour = 'red'", "say what it is with --kind"),
        ("steps = ", "not valid TOML"),
    ],
)
def test_a_wrong_file_is_told_in_one_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, says: str
) -> None:
    (tmp_path / "wrong.toml").write_text(text)
    assert says in refused(capsys, "config", "check", str(tmp_path / "wrong.toml"))


def test_a_scenario_with_a_box_in_the_robot_is_refused_before_a_run(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file, out = tmp_path / "crate.toml", tmp_path / "out"
    file.write_text('[[boxes]]\nname = "crate"\nsize = [0.2, 0.2, 0.3]\nat = [0.0, 0.0]\nmass = 0.3\n')
    out.mkdir()
    (out / "summary.json").write_text("of an earlier run")
    assert "`crate`" in refused(capsys, "config", "check", str(file))
    up = ("up", "--mode", "in-process", "--engine", "mujoco", "--scenario", str(file), "--out", str(out))
    assert "`crate`" in refused(capsys, *up)
    assert (out / "summary.json").read_text() == "of an earlier run"


@pytest.mark.parametrize(
    ("command", "says"),
    [
        ("plt", ["plot"]),
        ("plot x.mcap --what torzo", ["did you mean 'torso'"]),
        ("plot empty.mcap --from 1", ["holds no sensor frame from 1 s to its end"]),
        ("plot empty.mcap --from 3 --to 2", ["--to 2 is not after --from 3"]),
        ("replay empty.mcap --from 3 --to 2", ["--to 2 is not after --from 3"]),
        ("replay walk.mcap --speed 1e9", ["'--speed': it must be less than or equal to 1000"]),
        ("record --out no-such-folder/walk.mcap", ["no-such-folder/walk.mcap: cannot be written"]),
        ("view --port 65536", ["--port"]),
        ("up --view --port 0", ["--port"]),
        ("up --stps 3", ["--steps"]),
        ("up --steps nan", ["'--steps': it must be a whole number"]),
        ("world place ball 0.3 -0.1 --hieght 0.1", ["No such option: --hieght"]),
        ("up --velocity -0.1 0 0 --stepz 3", ["No such option: --stepz"]),
        ("world place ball -0.3 -0.1 --mass -1", ["World command refused: `mass`"]),
        ("up --steps 1 --mode in-process", ["steps is 1; a walk has at least 2"]),
        ("up --seed -1", ["seed"]),
        ("stop --name blue red", ["red and --name blue are two robots"]),
        ("arm --yes --name blue red", ["red and --name blue are two robots"]),
        ("up --mode fast", ["mode: unknown value 'fast'"]),
        ("up --robot nao-v7 --mode in-process", ["did you mean 'nao-v"]),
        ("up --wear wurn --mode in-process", ["did you mean 'worn'"]),
        ("up --listen 7447", ["must look like tcp/127.0.0.1:7447"]),
        ("emulate --name a/b", ["1 to 64 letters"]),
        ("walk --connect tcp/somewhere", ["needs a host and a port"]),
        ("walk --controller 'a b'", ["1 to 64 letters"]),
        ("walk --config no-such-file.toml", ["cannot be read"]),
        ("up --gait statc", ["unknown gait 'statc' (did you mean 'static'?)"]),
        ("up --serve --mode in-process --out run", ["no link"]),
        ("up --view --mode in-process --out run", ["no link"]),
        ("up --robot nao-v3.2 --start lie-back --mode in-process", ["nao-v3.2 has no motion to get up"]),
        ("emulate --mode in-process --out run", ["nao-hil up --mode in-process"]),
        ("bridge lola --robot nao-v9", ["did you mean 'nao-v"]),
        ("bridge lola --robot nao-v5", ["`nao-hil bridge naoqi`"]),
        ("bridge naoqi --url tcp://127.0.0.1:9559 --robot nao-v9", ["did you mean 'nao-v"]),
        ("export mjcf --robot nao-v66 --out x.xml", ["'nao-v66'", "did you mean 'nao-v6'", "nao-v5"]),
        ("export mjcf nao-v66 --out x.xml", ["'nao-v66' needs an option before it", "--robot", "--wear"]),
        ("export nao-v66 --out x.xml", ["unknown export 'nao-v66'", "mjcf, rosbag, run, urdf", "--robot"]),
        ("export mjfc --robot nao-v6 --out x.xml", ["unknown export 'mjfc' (did you mean 'mjcf'?)"]),
        ("results '' .", ["no walks are kept there"]),
        ("results .", ["is a folder; the query comes first"]),
        ("map push=0:8 push=0:8 --out map", ["push is given twice"]),
        ("motion getup", ["did you mean 'get-up'?", "get-up-back", "sit-down", ", or a file"]),
        ("motion sit-down --seed 1 --connect tcp/127.0.0.1:1", ["--seed is for a robot in this process"]),
        ("motion get-up --robot nao-v3.2 --engine mujoco", ["nao-v3.2 has no motion to get up from its back"]),
        (
            "motion get-up-front --start stand --engine mujoco",
            ["get-up-front begins with the torso: front; with --start stand it is: upright"],
        ),
    ],
)
def test_a_wrong_command_is_refused_in_one_sentence_and_leaves_nothing(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    says: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with Recorder(Path("empty.mcap"), RunConfig()):
        pass
    sentence = refused(capsys, *shlex.split(command))
    assert all(part in sentence for part in says), sentence
    assert [path.name for path in tmp_path.iterdir()] == ["empty.mcap"]


def test_info_ends_with_one_json_object(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with Recorder(tmp_path / "empty.mcap", RunConfig(seed=9)):
        pass
    contents = json.loads(shown(capsys, "info", str(tmp_path / "empty.mcap"), "--json"))
    assert contents["complete"]
    assert contents["config"]["seed"] == 9
    assert contents["cycles"] == 0
    assert contents["diagnosis"] is None
    whole = (tmp_path / "empty.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[:-20])
    assert not json.loads(shown(capsys, "info", str(tmp_path / "cut.mcap"), "--json"))["complete"]


def test_info_says_what_went_wrong_first(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "fall.mcap"
    with (
        EmulatedRobot(load_body("nao-v3"), seed=0, engine="mujoco") as robot,
        Recorder(file, RunConfig()) as recorder,
    ):
        robot.world_events.execute(Push(impulse=(0.0, 5.0, 0.0)))
        for _ in repeat_while(lambda: not robot.truth().fell, 500):
            robot.advance(None)
            recorder.sensors(robot.frame, robot.truth())
    diagnosis = json.loads(shown(capsys, "info", str(file), "--json"))["diagnosis"]
    assert re.match(r"The robot fell at \d\.\d+ s; first, at \d\.\d+ s, ", diagnosis)
    assert "what went wrong" in shown(capsys, "info", str(file))


@pytest.mark.parametrize(
    ("redirection", "code", "says"),
    [
        (
            "> /dev/full",
            3,
            ["error: nothing more can be written (No space left on device); make room, or write elsewhere."],
        ),
        (">&-", 0, []),
        ("| true", 0, []),
    ],
)
def test_an_output_that_nobody_takes_is_no_fault(redirection: str, code: int, says: list[str]) -> None:
    # a world that is not flat: the robot is placed in it, by an engine that prints when it is loaded
    show = f"{sys.executable} -m nao_hil.cli config show --scenario step --engine pybullet"
    script = f"set -o pipefail; {show} {redirection}"
    done = subprocess.run(
        ["bash", "-c", script], cwd=REPOSITORY, capture_output=True, text=True, timeout=TIMEOUT, check=False
    )
    assert (done.returncode, done.stderr.splitlines()) == (code, says)


@pytest.mark.parametrize(
    ("typed", "offers"),
    [
        ("nao-hil re", {"record", "replay", "results"}),
        ("nao-hil up --gait st", {"static"}),
        ("nao-hil experiment t", {"torso-drift", "torso-step", "torso-design", "terrain", "tracking"}),
        ("nao-hil up --scenario slope-", {"slope-5", "slope-down-5", "slope-side-5"}),
        ("nao-hil plot x.mcap --what torso,ce", {"torso,cells"}),
    ],
)
def test_the_shell_completes_names(
    typed: str, offers: set[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["nao-hil"])
    monkeypatch.setenv("_NAO_HIL_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", typed)
    monkeypatch.setenv("COMP_CWORD", str(len(typed.split(" ")) - 1))
    run()
    assert set(capsys.readouterr().out.split()) == offers


@pytest.mark.parametrize(
    ("command", "named"),
    [
        ("up --wear bogus", "'bogus'"),
        ("up --scenario bogus", "'bogus'"),
        ("emulate --wear bogus", "'bogus'"),
        ("emulate --scenario bogus", "'bogus'"),
        ("up --mode in-process --gait huang --velocity 2 0 0", "2 m/s"),
        ("up --mode in-process --start lyng", "'lyng'"),
    ],
)
def test_a_run_that_cannot_begin_leaves_its_folder_as_it_was(
    command: str, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "frames.mcap").write_text("old")
    # at the default endpoint is a page of the docs
    said = refused(capsys, *command.split(), "--listen", free_endpoint(), "--out", str(tmp_path))
    assert named in said
    assert (tmp_path / "frames.mcap").read_text() == "old"


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ('[start]\npose = "lying"\n', "start.pose: unknown value 'lying'"),
        ('[start]\nposture = "StandIni"\n', "unknown posture 'StandIni' (did you mean 'StandInit'?)"),
    ],
)
def test_a_scenario_that_a_run_refuses_is_refused_by_its_check_and_costs_no_earlier_run(
    text: str, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario, run = tmp_path / "mine.toml", tmp_path / "run"
    scenario.write_text(text)
    run.mkdir()
    (run / "summary.json").write_text("old")
    up = ("up", "--mode", "in-process", "--scenario", str(scenario), "--duration", "0.2", "--out", str(run))
    for command in (up, ("config", "check", str(scenario))):
        said = refused(capsys, *command)
        assert f"{scenario}: " in said and named in said
    assert [path.name for path in run.iterdir()] == ["summary.json"]


def test_a_demo_beside_another_robot_commands_neither(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        listen = f"tcp/127.0.0.1:{other.getsockname()[1]}"
        assert run(["demo", "--no-view", "--listen", listen, "--out", str(tmp_path / "run")]) == 3
    assert f"Cannot listen on {listen}: Address already in use" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
