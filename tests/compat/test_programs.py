"""Programs in the style of the vendor's samples run unchanged and print what they do on a robot."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from bridge.errors import ConfigurationError
from bridge.messages.world_state import WorldThing
from nao_hil.naoqi_programs.choregraphe.project import read_behaviour
from nao_hil.naoqi_programs.source import compiled
from tests.loops import TIMEOUT
from tests.ports import free_endpoint, free_port
from tests.system.naoqi_robot import obedient_robot, serve, wait_for

pytest.importorskip("qi")

PROGRAMS = Path(__file__).parent / "programs"
LINES = ",\n"


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


EXPECTED = """
old.py.txt nao.local -> 7: said 3
threads.py.txt -> 3: main part ends | danced 0.5 | rested
old_ear.py.txt -> 0: heard (1, 1365) False
joints.py 192.168.1.2 -> 0: set 0.3 -0.2 | through 0.2 0.1 | runs True | runs False | limits 26 names 26
module_events.py -> 0: touched FrontTactilTouched 1.0 | subscribers []
qi_events.py --ip nao.local -> 0: heard ['yes'] | said False
application.py -> 1: data [1, 'two', 3.0] | life disabled
cartesian.py nao.local -> 0: near True | camera up True | moved [0.0, 0.0, 0.0] | half turn 180
tasks.py -> 0: tasks ['angleInterpolation', 'angleInterpolation'] True | then -0.3 [] | arm True near | arm
    False collision | breathes True [['Bpm', 12.0], ['Amplitude', 0.5]]
pictures.py -> 0: size 320 240 3 of 230400 camera 1 | gone True False | grey 19200 angles [0.53, -0.42, -0.53
    | red True
ball.py -> 0: ball left True below | followed True | lost False
frame_manager.py -> 0: programs True | beeped 3 | ALFrameManager.playFrames is not offered: clea |
    ALFrameManager.newBehaviorFromFile: /no.xar: can | ALFrameManager: 9 is no behaviour; newBehaviorFr
photos.py -> 0: names ['image_0.jpg', 'image_1.jpg'] | one single.jpg | picture JPEG (320, 240) True | records
    True | film film.avi True b'RA'
facts.py -> 0: memory True 1 | body Nao True | network ready ['Wired'] ['ethernet'] | help ['setStiffnesses',
    [['names', ''], ['stiffnesses', '']]] | voice True | refused True True
quiet.py -> 0: ALDarknessDetection [] me | ALBarcodeReader [] me | ALMovementDetection [] me |
    ALSoundDetection [] me | topics ['greeting'] ['greeting'] | turned True 3 2
dialog.py -> 0: topic greeting | answer Hello Anna, nice to meet you | again What about you? | variable Anna |
    heard Yes | jumped So am I | not understood what
sensors.py -> 0: sonar 0.5 weight 2.0 None | battery 90 | red 1.0
errors.py -> 1: ALProxy: there is no service ALNothing (qi: Cannot find serv | ALMotion: unknown method
    'setAngels' (did you mean 'setAngle | ALMotion.animation is not offered by nao-hil: no anim | nao-v5:
    unknown joint or chain 'Nose' | ALMemory: there is no data under 'Nothing'. | The behaviour 'dance' is not
    installed: the
"""
"""A program with its arguments, its exit code, and how the lines begin that it prints; indented lines go on."""


def expectations() -> list[tuple[str, list[str], int, list[str]]]:
    """Program, arguments, exit code and beginnings of lines of `EXPECTED`."""
    found = []
    for row in EXPECTED.replace("\n    ", " ").strip().splitlines():
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


@pytest.mark.parametrize(
    ("source", "value"),
    [
        ("print\nx = 7 / 2, -7 / 2, 7.0 / 2", (3, -4, 3.5)),
        ("from __future__ import division\nprint\nx = 7 / 2", 3.5),
        ("def f():\n\tn = 8\n        global n\n\tn /= 3\nf()\nx = n", 2),
        ("x = sum(xrange(4))", 6),
        ("print'a'\nx = 7 / 2", 3),
        ("print'a'\nclass Greeter:\n    'Begrüßt Gäste'\nx = Greeter().__doc__", "Begrüßt Gäste"),
        (f"print'a'\nx = [{LINES.join(['[0.5, -2e-3]'] * 40)}]", [[0.5, -0.002]] * 40),
        (f"print'a'\nx = [{'010, 8, ' * 60}]", [8, 8] * 60),
        ("print ''\nx = map(ord, bytearray('ab', 'ascii')) + [ord('c')]", [97, 98, 99]),
        ("x = {1: 2}.has_key(1)", True),
        ("try:\n    raise ValueError, 'bad'\nexcept ValueError, e:\n    x = str(e)", "bad"),
        ("x = 1; print x", 1),
        ("if False: print 'a'\nelse: print 'b'\nx = 2", 2),
        ("try:\n    pass; raise ValueError, 'bad'\nexcept ValueError: x = 3", 3),
        ("x = 7 / 2", 3.5),  # Python 3 reads it: it is Python 3
    ],
)
def test_a_program_in_python_2_means_what_it_meant(source: str, value: Any) -> None:
    assert meaning(source)["x"] == value


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
    assert said == [
        "Greeting: said hello",
        "Beep: at frame 5",
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
