"""Programs in the style of the vendor's samples run unchanged and print what they do on a robot."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from bridge.config import read_toml
from bridge.errors import ConfigurationError
from bridge.messages.world_state import WorldThing
from nao_hil.naoqi_programs.choregraphe.project import read_behaviour
from nao_hil.naoqi_programs.source import compiled
from tests.loops import TIMEOUT
from tests.ports import free_endpoint, free_port
from tests.system.naoqi_robot import obedient_robot, serve, wait_for

pytest.importorskip("qi")

PROGRAMS = Path(__file__).parent / "programs"


class Server(NamedTuple):
    """Serves a robot without physics."""

    url: str
    process: subprocess.Popen[bytes]
    log: Path


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    endpoint, address = free_endpoint(), f"tcp://127.0.0.1:{free_port()}"
    log = tmp_path_factory.mktemp("served") / "log"
    ball = WorldThing(name="b", kind="ball", size=0.06, position=(0.35, 0.05, 0.03), facing=(1.0, 0.0, 0.0))
    with obedient_robot("nao-v5", endpoint, (ball,)):
        process = serve(address, endpoint, log)
        try:
            wait_for("is served at", log)
            yield Server(address, process, log)
        finally:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def url(server: Server) -> str:
    return server.url


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


def expectations() -> list[tuple[str, list[str], int, list[str]]]:
    """Of `expected.txt`: program, arguments, exit code, and beginnings of its lines; indented lines go on."""
    found = []
    for row in (PROGRAMS / "expected.txt").read_text().replace("\n    ", " ").strip().splitlines():
        call, _, lines = row.partition(": ")
        words, _, code = call.partition(" -> ")
        name, *arguments = words.split()
        found.append((name, arguments, int(code), lines.split(" | ")))
    return found


@pytest.mark.parametrize(("name", "arguments", "code", "lines"), expectations())
def test_a_program_does_what_it_does_on_a_robot(
    url: str, name: str, arguments: list[str], code: int, lines: list[str]
) -> None:
    done = run(url, PROGRAMS / name, *arguments)
    said = done.stdout.splitlines()
    assert done.returncode == code, done.stderr
    assert [line[: len(start)] for line, start in zip(said, lines, strict=True)] == lines
    assert ("the program's own" in done.stderr) == (name == "errors.py")


def test_a_program_that_is_interrupted_lays_the_robot_to_rest(url: str) -> None:
    """Before, it was ended before its own last calls."""
    command = [
        sys.executable,
        "-m",
        "nao_hil.cli",
        "run-naoqi",
        "--url",
        url,
        str(PROGRAMS / "interrupted.py.txt"),
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert process.stdout is not None
    assert any(line == "runs\n" for line in process.stdout)  # qi's own log may come before
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    said = process.communicate(timeout=TIMEOUT)[0].splitlines()
    assert [line for line in said if " qi." not in line] == ["", "interrupted", "rested False"]
    assert process.returncode == 0


def meaning(source: str) -> dict[str, Any]:
    """The names that a program leaves."""
    scope: dict[str, Any] = {"__name__": "__main__"}
    exec(compiled(source.encode(), "program.py"), scope)
    return scope


@pytest.mark.parametrize(("source", "value"), read_toml(PROGRAMS.parent / "python2.toml")["meanings"])
def test_a_program_in_python_2_means_what_it_meant(source: str, value: Any) -> None:
    x = meaning(source)["x"]
    assert (list(x) if isinstance(x, tuple) else x) == value


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("def (:\n", ", line 1: "),
        ("print 'a' 'b\n", ", line 1: unterminated string literal"),
        ("print 'a'\nx = (1,\ny = 2\n", ", line 3: bad input"),
        ("print 'a'\nx = (1,\n", ", line 3: "),
        (f"print 'a'\nx = [{'1.5, ' * 50}\n{'2, ' * 50}]\ny = (\nz = 2\n", ", line 5: bad input"),
        ("print 'a'\nx = 7 /\n", ", line 2: "),
        ("return 3\n", ", line 1: 'return' outside function"),
        ("x = \0", ": source code (string )?cannot contain null bytes"),
    ],
)
def test_what_is_no_python_is_told_with_its_line(source: str, said: str) -> None:
    with pytest.raises(ConfigurationError, match=rf"program.py{said}.*this is no Python program"):
        compiled(source.encode(), "program.py")


def test_an_error_in_a_callback_is_told_with_the_program_s_lines(url: str) -> None:
    """The error itself goes to ALMemory, which nobody sees."""
    done = run(url, PROGRAMS / "module_faults.py")
    assert done.returncode == 0
    assert done.stdout.splitlines() == [
        "ALMemory.subscribeToEvent: module Faulty has no method noSuchMethod.",
        "nobody is taken",
        "the robot's own True",
    ]
    traced = done.stderr[done.stderr.index("Traceback") :].splitlines()
    assert [line.split(", ")[-1] for line in traced if "File" in line] == ["in onEvent", "in helper"]
    assert traced[-1] == "ValueError: no 3"


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
    *said, last = done.stdout.splitlines()
    said.remove("Beep: at frame 5")  # a thread of its own says it
    assert said == [
        "Greeting: said hello",
        "Check: head -0.09 counted 3",  # the last key of the head is at -5 degrees
        "half of 7 3",  # in Python 2
    ], done.stderr
    report = json.loads(last)
    assert report["exit_code"] == done.returncode == 1
    assert sorted(sentence[:36] for sentence in report["could_not"]) == [
        "the box Old failed in onInput_onStar",
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


def test_a_port_in_use_is_told_in_a_sentence(server: Server, tmp_path: Path) -> None:
    process = serve(server.url, "tcp/127.0.0.1:9", tmp_path / "log")
    assert process.wait(TIMEOUT) == 3
    assert f"Cannot listen on {server.url}: address already in use" in (tmp_path / "log").read_text()


def test_a_termination_ends_the_server_in_good_order(server: Server) -> None:
    """The last one here."""
    server.process.send_signal(signal.SIGTERM)
    assert server.process.wait(TIMEOUT) == 0
    host, port = server.url.removeprefix("tcp://").split(":")
    with socket.socket() as probe:
        assert probe.connect_ex((host, int(port))) != 0
    assert "Traceback" not in server.log.read_text()
