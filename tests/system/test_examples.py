"""Every example does what it says, against a robot of this machine."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_hil
from bridge.errors import LinkError, WalkRefused
from bridge.link import ControllerLink
from bridge.link.client import WalkClient
from nao_hil.cli.main import run
from tests.loops import TIMEOUT, repeat_while, until
from tests.processes import REPOSITORY, module_of, python

EXAMPLES = REPOSITORY / "examples"


def output(name: str, *arguments: str) -> str:
    done = python(EXAMPLES / name, *arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.\d+", text)]


def wait_for_robot(endpoint: str) -> None:
    with ControllerLink(connect=endpoint, name="test") as link:
        link.wait_robot(timeout=TIMEOUT)


@pytest.fixture
def robot(start: Callable[..., Any], endpoint: str) -> str:
    start("emulate", "--engine", "mujoco", "--mode", "lockstep", "--listen", endpoint)
    wait_for_robot(endpoint)
    return endpoint


@pytest.fixture
def served(start: Callable[..., Any], robot: str) -> Iterator[str]:
    start("walk", "--serve", "--torso", "none", "--connect", robot)

    def answers() -> bool:
        try:
            client.status()
        except (LinkError, WalkRefused):
            return False
        return True

    with WalkClient(connect=robot, connect_timeout=TIMEOUT) as client:
        until(answers, "a walker that serves")
        yield robot


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.*")), ids=lambda file: file.name)
def test_examples_are_short_and_listed(file: Path) -> None:
    assert file.suffix == ".ipynb" or len(file.read_text().splitlines()) < 100
    assert file.name == "README.md" or f"`{file.name}`" in (EXAMPLES / "README.md").read_text()


def test_own_controller(robot: str) -> None:
    depth, *_ = numbers(output("own_controller.py", robot))
    assert depth == pytest.approx(0.4, abs=0.03)


def test_own_controller_with_msgpack_alone(robot: str) -> None:
    text = output("own_controller_msgpack.py", robot)
    assert numbers(text) == pytest.approx([-0.3, 0.3], abs=0.03)
    code = (EXAMPLES / "own_controller_msgpack.py").read_text()
    assert not re.search(r"^(from|import) (bridge|emulator|walker|nao_hil)", code, re.MULTILINE)


def test_training_environment_in_mujoco_alone(tmp_path: Path) -> None:
    assert run(["export", "folder", "--robot", "nao-v6", "--out", str(tmp_path)]) == 0
    seen = [
        output("mujoco_env.py", str(tmp_path / "scene.xml"), "--noise", "0", *changes)
        for changes in ([], ["--no-play", "--delay", "0.001"], [])
    ]
    assert all(text.startswith("31 numbers seen, 11 joints") and "fell: False" in text for text in seen)
    assert seen[0] == seen[2] != seen[1]
    code = (EXAMPLES / "mujoco_env.py").read_text()
    assert not re.search(r"^(from|import) (bridge|emulator|walker|nao_hil)", code, re.MULTILINE)


def test_walk_command_and_push(served: str, capsys: pytest.CaptureFixture[str]) -> None:
    lines = output("walk_command.py", served).splitlines()
    # by the odometry; the closing step and the stop are not steered
    assert numbers(lines[1]) == pytest.approx([0.05], abs=0.03)
    assert numbers(lines[3])[0] > 0.1
    assert lines[4].startswith("refused: This gait walks straight ahead")
    push = module_of(EXAMPLES / "push.py")
    push.WATCH = 1.2
    push.main(served)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "0.5 N s: stands"
    assert lines[-2].endswith("N s: falls")


def test_dcm_command(start: Callable[..., Any], endpoint: str) -> None:
    start("emulate", "--engine", "mujoco", "--listen", endpoint)
    wait_for_robot(endpoint)
    lines = output("dcm_command.py", endpoint).splitlines()
    assert [line.split(" ")[0] for line in lines] == ["500", "1000", "1500"]
    assert numbers(lines[-1]) == pytest.approx([0.4], abs=0.05)


def test_robot() -> None:
    lines = output("robot.py", "nao-v6").splitlines()
    assert [line.split(":")[0] for line in lines] == ["nao-v6, ideal", "nao-v6, nominal", "nao-v6, worn"]
    assert abs(numbers(lines[0])[-1]) < 0.01


def test_batch(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Of walks of two seconds."""
    walk = nao_hil.walk
    monkeypatch.setattr(nao_hil, "walk", lambda *gait, **how: walk(*gait, **how | {"duration": 2.0}))
    module_of(EXAMPLES / "batch.py").main(1, str(EXAMPLES / "polished.toml"))
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines] == ["torso control none", "torso control robust"]


def test_games_are_those_of_their_seeds() -> None:
    games = output("games.py", "--games", "2", "--seconds", "1", "--workers", "1").splitlines()[:-1]
    assert sorted(re.findall(r"'seed': (\d)", "".join(games))) == ["0", "1"]
    assert all("'down': {'red': 0.0, 'blue': 0.0}" in game for game in games)


def test_read_recording(tmp_path: Path) -> None:
    nao_hil.walk("dynamic", steps=4, torso="none", wear="ideal", engine="mujoco", record=tmp_path / "walk.mcap")
    lines = output("read_recording.py", str(tmp_path / "walk.mcap")).splitlines()
    assert lines[0] == "nao-v3, gait dynamic"
    loads = {line.split()[0]: numbers(line)[1] for line in lines[1:]}
    assert loads["SSL"] > 3.0 * loads["SSR"]  # on the left foot in left single support


def test_the_learner_writes_its_pattern_and_its_curve(tmp_path: Path) -> None:
    pytest.importorskip("gymnasium")
    options = ("--minutes", "0", "--robots", "2", "--seconds", "0.2", "--out", str(tmp_path))
    lines = output("learn_to_walk.py", *options)
    assert re.search(r"generation 1: mean pattern -?0\.\d+ m, best -?0\.\d+ m", lines)
    assert (tmp_path / "curve.png").exists()
    assert len((tmp_path / "pattern.txt").read_text().split("\n")) == 10  # a heading, eight numbers, an end


def test_a_pattern_walks_over_the_link_as_in_the_environment(
    start: Callable[..., Any], endpoint: str, tmp_path: Path
) -> None:
    """The same angles measured in lockstep over the link and by a robot in this process, to the last bit."""
    pytest.importorskip("mujoco")
    pattern = tmp_path / "pattern.txt"
    pattern.write_text("1.7 0.2 0.08 0.4 0.05 0.0 0.02 0.03\n")
    example = module_of(EXAMPLES / "walk_learnt.py")
    tilt = 0.0
    with nao_hil.Robot("nao-v6", seed=5, engine="mujoco") as robot:
        for _ in repeat_while(lambda: robot.frame.time < 1.2, 200):
            when = robot.frame.time
            command = example.POSTURE.copy()
            rates = np.array([robot.frame.gyroscope])
            size = min(when, 1.0, 1.2 - when)
            command[example.LEGS] += example.leg_angles(np.loadtxt(pattern)[None], rates, when, size)[0]
            tilt = max(tilt, *map(abs, robot.step(command).angle))
    start(
        "emulate",
        "--mode",
        "lockstep",
        "--robot",
        "nao-v6",
        "--engine",
        "mujoco",
        "--seed",
        "5",
        "--listen",
        endpoint,
    )
    lines = output("walk_learnt.py", str(pattern), endpoint, "--seconds", "1.2").splitlines()
    assert lines[0] == "100 answers in 100 cycles, 0 missed"
    assert lines[1] == f"tilt at most {math.degrees(tilt):.3f} deg"
    assert tilt > math.radians(0.5)
