"""Every example does what it says, against a robot of this machine."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import nao_hil
from bridge.errors import LinkError, WalkRefused
from bridge.link import ControllerLink
from bridge.link.walk_client import WalkClient
from tests.loops import until
from tests.system.conftest import REPOSITORY

EXAMPLES = REPOSITORY / "examples"


def output(name: str, *arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name), *arguments],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.\d+", text)]


def wait_for_robot(endpoint: str) -> None:
    with ControllerLink(connect=endpoint, name="test") as link:
        link.wait_robot(timeout=60.0)


@pytest.fixture
def robot(start: Callable[..., Any], endpoint: str) -> str:
    start("emulate", "--mode", "lockstep", "--listen", endpoint)
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

    with WalkClient(connect=robot, connect_timeout=60.0) as client:
        until(answers, "a walker that serves")
        yield robot


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.*")), ids=lambda file: file.name)
def test_examples_are_short_and_listed(file: Path) -> None:
    assert len(file.read_text().splitlines()) < 60
    assert file.name == "README.md" or f"`{file.name}`" in (EXAMPLES / "README.md").read_text()


def test_own_controller(robot: str) -> None:
    depth, *_ = numbers(output("own_controller.py", robot))
    assert depth == pytest.approx(0.4, abs=0.03)


def test_own_controller_with_msgpack_alone(robot: str) -> None:
    text = output("own_controller_msgpack.py", robot)
    assert numbers(text) == pytest.approx([-0.3, 0.3], abs=0.03)
    code = (EXAMPLES / "own_controller_msgpack.py").read_text()
    assert not re.search(r"^(from|import) (bridge|emulator|walker|nao_hil)", code, re.MULTILINE)


def test_walk_command(served: str) -> None:
    lines = output("walk_command.py", served).splitlines()
    assert numbers(lines[1]) == pytest.approx([0.05])
    assert numbers(lines[3])[0] > 0.1
    assert lines[4].startswith("refused: This gait walks straight ahead")


def test_push(served: str) -> None:
    lines = output("push.py", served).splitlines()
    assert lines[0] == "0.5 N s: stands"
    assert lines[-2].endswith("N s: falls")


def test_dcm_command(start: Callable[..., Any], endpoint: str) -> None:
    start("emulate", "--listen", endpoint)
    wait_for_robot(endpoint)
    lines = output("dcm_command.py", endpoint).splitlines()
    assert [line.split(" ")[0] for line in lines] == ["500", "1000", "1500"]
    assert numbers(lines[-1]) == pytest.approx([0.4], abs=0.05)


def test_robot() -> None:
    lines = output("robot.py", "nao-v6").splitlines()
    assert [line.split(":")[0] for line in lines] == ["nao-v6, ideal", "nao-v6, nominal", "nao-v6, worn"]
    assert abs(numbers(lines[0])[-1]) < 0.01


def test_batch() -> None:
    lines = output("batch.py", "1", str(EXAMPLES / "polished.toml")).splitlines()
    assert [line.split(":")[0] for line in lines] == ["torso control none", "torso control robust"]


def test_read_recording(tmp_path: Path) -> None:
    nao_hil.walk("dynamic", steps=4, torso="none", wear="ideal", record=tmp_path / "walk.mcap")
    lines = output("read_recording.py", str(tmp_path / "walk.mcap")).splitlines()
    assert lines[0] == "nao-v3, gait dynamic"
    loads = {line.split()[0]: numbers(line)[1] for line in lines[1:]}
    assert loads["SSL"] > 3.0 * loads["SSR"]  # on the left foot in left single support
