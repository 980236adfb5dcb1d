"""Programs in the style of the vendor's samples run unchanged and print what they do on a robot."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from bridge.errors import ConfigurationError
from bridge.messages.world_state import WorldThing
from nao_hil.naoqi_programs.choregraphe.project import read_behaviour
from nao_hil.naoqi_programs.source import require_python3
from tests.loops import TIMEOUT
from tests.ports import free_endpoint, free_port
from tests.system.naoqi_robot import obedient_robot, serve, wait_for

pytest.importorskip("qi")

PROGRAMS = Path(__file__).parent / "programs"


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a served robot without physics."""
    endpoint, address = free_endpoint(), f"tcp://127.0.0.1:{free_port()}"
    log = tmp_path_factory.mktemp("served") / "log"
    ball = WorldThing(name="b", kind="ball", size=0.06, position=(0.35, 0.05, 0.03), facing=(1.0, 0.0, 0.0))
    with obedient_robot("nao-v5", endpoint, (ball,)):
        process = serve(address, endpoint, log)
        try:
            wait_for("is served at", log)
            yield address
        finally:
            process.kill()
            process.wait()


def run(url: str, program: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "nao_hil.cli", "run-naoqi", "--url", url, str(program), *arguments],
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        cwd=PROGRAMS.parents[2],
        env=os.environ | {"COLUMNS": "200"},
        stdin=subprocess.DEVNULL,
    )


@pytest.mark.parametrize(
    ("name", "arguments", "code", "lines"),
    [
        ("hello", ["nao.local"], 7, ["said"]),
        (
            "joints",
            ["192.168.1.2"],
            0,
            ["set 0.3 -0.2", "through 0.2 0.1", "runs True", "runs False", "limits 26 names 26"],
        ),
        ("module_events", [], 0, ["touched FrontTactilTouched 1.0", "subscribers []"]),
        ("qi_events", ["--ip", "nao.local"], 0, ["heard ['yes']", "said False"]),
        ("application", [], 1, ["data [1, 'two', 3.0]", "life disabled"]),
        (
            "cartesian",
            ["nao.local"],
            0,
            ["near True", "camera up True", "moved [0.0, 0.0, 0.0]", "half turn 180"],
        ),
        (
            "pictures",
            [],
            0,
            [
                "size 320 240 3 of 230400 camera 1",
                "gone True False",
                "grey 19200 angles [0.53, -0.42, -0.53",
                "red True",
            ],
        ),
        ("ball", [], 0, ["ball left True below", "followed True", "lost False"]),
        ("sensors", [], 0, ["sonar 0.5 weight 2.0 None", "battery 90", "red 1.0"]),
        (
            "errors",
            [],
            1,
            [
                "ALProxy: there is no service ALNothing (Cannot find service",
                "ALMotion has no method setAngels; it has angleInterpolation",
                "ALMotion.wbEnable is not offered by nao-hil: whole-body",
                "'Nose' is no joint of nao-v5 and no chain",
                "ALMemory: there is no data under 'Nothing'.",
                "ALBehaviorManager.runBehavior: the behaviour 'dance' is",
            ],
        ),
    ],
)
def test_a_program_does_what_it_does_on_a_robot(
    url: str, name: str, arguments: list[str], code: int, lines: list[str]
) -> None:
    done = run(url, PROGRAMS / f"{name}.py", *arguments)
    said = [line for line in done.stdout.splitlines() if not line.startswith("[")]  # qi writes there, too
    assert done.returncode == code, done.stderr
    assert [line[: len(start)] for line, start in zip(said, lines, strict=True)] == lines
    assert ("the program's own" in done.stderr) == (name == "errors")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            (PROGRAMS / "old.py.txt").read_text(),
            r"is written for Python 2 \(line 4\); convert it first, with `2to3",
        ),
        ("if True:\n\tx = 1\n        y = 2\n", "is written for Python 2"),
        ("def (:\n", "line 1: invalid syntax; this is no Python program"),
    ],
)
def test_a_program_in_python_2_is_told_from_a_broken_one(tmp_path: Path, text: str, sentence: str) -> None:
    program = tmp_path / "program.py"
    program.write_text(text)
    with pytest.raises(ConfigurationError, match=sentence):
        require_python3(program)


def test_a_choregraphe_project_is_played_and_what_it_could_not_do_is_listed(url: str) -> None:
    project = PROGRAMS.parent / "choregraphe" / "greet" / "greet.pml"
    done = subprocess.run(
        [sys.executable, "-m", "nao_hil.cli", "run-choregraphe", "--url", url, "--json", str(project)],
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        cwd=PROGRAMS.parents[2],
        stdin=subprocess.DEVNULL,
    )
    *said, last = [line for line in done.stdout.splitlines() if not line.startswith("[")]
    # the last key of the head is at -5 degrees
    assert said == ["Greeting: said hello", "Beep: at frame 5", "Check: head -0.09 counted 3"], done.stderr
    report = json.loads(last)
    assert report["exit_code"] == done.returncode == 1
    assert sorted(sentence[:36] for sentence in report["could_not"]) == [
        "the box Old was not played: its scri",
        "the timeline of Nod: this robot has ",
    ]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('<!DOCTYPE x [<!ENTITY a "aa">]><x>&a;</x>', "declares a document type"),
        ("<x>", "cannot be read"),
        ("<ChoregrapheProject/>", "it has no box"),
        ('<C><Box name="a" id="b"><Input id="c"/></Box></C>', "box `a` cannot be read"),
    ],
)
def test_a_broken_project_is_one_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    file = tmp_path / "behavior.xar"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=sentence):
        read_behaviour(file)
