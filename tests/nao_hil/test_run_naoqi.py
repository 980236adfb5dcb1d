"""`nao-hil run-naoqi` starts what does not run yet, and only that."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from bridge.adapters.naoqi import qi_library
from nao_hil.cli.main import run
from nao_hil.naoqi_programs.loading import command
from nao_hil.naoqi_programs.runner import ADDRESS, main
from tests.loops import TIMEOUT
from tests.ports import free_endpoint, free_port


def test_what_is_no_naoqi_is_told_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("qi")
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        monkeypatch.setenv(ADDRESS, url)
        monkeypatch.setattr("nao_hil.naoqi_programs.runner.PATIENCE", 0.2)
        assert main(tmp_path / "code", "hello.py", []) == 3
    assert capsys.readouterr().err.endswith(
        f"error: No NAOqi answers at {url} (no answer). Stop what listens there, or give another --url.\n"
    )


def test_modules_of_the_working_directory_do_not_replace_those_of_this_project(tmp_path: Path) -> None:
    pytest.importorskip("qi")
    for name in ("bridge", "nao_hil", "qi"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('not this one')\n")
    path = os.pathsep.join(place or os.getcwd() for place in sys.path)
    environment = os.environ | {ADDRESS: f"tcp://127.0.0.1:{free_port()}", "PYTHONPATH": path}
    words = command(tmp_path / "code", tmp_path / "hello.py", [])
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=TIMEOUT)
    assert done.returncode == 3 and "No NAOqi answers" in done.stderr


def test_programs_started_together_share_one_robot(tmp_path: Path) -> None:
    """Before, the second one found a robot without a server, and a port or a lease that was taken."""
    pytest.importorskip("qi")
    program = tmp_path / "hello.py"
    program.write_text(
        'from naoqi import ALProxy\nALProxy("ALTextToSpeech", "nao.local", 9559).say("Hello")\n'
        "import os, sys, time\nopen(os.path.join(sys.argv[1], str(os.getpid())), 'w').close()\n"
        "for _ in range(2000):\n"  # until the other one has spoken, too
        "    if len(os.listdir(sys.argv[1])) == 2: break\n"
        "    time.sleep(0.05)\n"
    )
    spoken = tmp_path / "spoken"
    spoken.mkdir()
    places = ["--url", f"tcp://127.0.0.1:{free_port()}", "--connect", free_endpoint()]
    command = [sys.executable, "-m", "nao_hil.cli", "run-naoqi", *places, "--json", str(program), str(spoken)]
    programs = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    started = [json.loads(process.communicate(timeout=TIMEOUT)[0]) for process in programs]
    assert sorted(started, key=lambda result: len(result["started"])) == [
        {"exit_code": 0, "started": []},
        {"exit_code": 0, "started": ["robot", "server"]},
    ]


@pytest.mark.parametrize(
    "command", ["serve naoqi", "bridge naoqi --url tcp://127.0.0.1:1", "run-naoqi program.py"]
)
def test_without_qi_every_command_of_naoqi_says_where_there_is_a_package(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "qi", None)
    monkeypatch.setattr(qi_library, "NEWEST_PYTHON", (3, 9))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "program.py").write_text("print()")
    assert run(command.split()) == 3
    said = " ".join(capsys.readouterr().err.split())
    assert "Traceback" not in said
    assert "the package qi is not installed for" in said and "Python 3.8 to 3.12 on Linux x86-64 only" in said
