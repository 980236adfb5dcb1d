"""`nao-hil run-naoqi` and `run-choregraphe`: programs written for NAOqi on a robot of the link."""

from __future__ import annotations

import json
import marshal
import math
import os
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import CodeType
from typing import Annotated

import typer

from bridge.adapters.naoqi.interaction.speech import SPOKEN_PREFIX
from bridge.adapters.naoqi.qi_library import DEFAULT_URL, check_url, require_qi
from bridge.adapters.naoqi.robot_files import HOME_PREFIX
from bridge.body import load_body
from bridge.errors import ConfigurationError, LinkError
from bridge.link import DEFAULT_ENDPOINT
from bridge.link.certificates import split_endpoint
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console, printable
from nao_hil.cli.signals import on_signals
from nao_hil.naoqi_programs.choregraphe.project import behaviours, read_behaviour
from nao_hil.naoqi_programs.loading import command
from nao_hil.naoqi_programs.runner import ADDRESS
from nao_hil.naoqi_programs.source import program_code
from nao_hil.runs.supervisor import Child

START = 120.0
"""s that robot and server may take to start."""
GRACE = 30.0
"""s that each has to end."""
FAREWELL = 60.0
"""s that a program has after a Ctrl-C, in which it may sit the robot down."""
_REPORTED = re.compile(rf"{SPOKEN_PREFIX}.*|{HOME_PREFIX}.*|WARNING .*")
"""Lines of the server's log that are printed."""
BODY = "nao-v5"
"""Body of a robot that is started, by default."""
OWN_OPTIONS = ("--robot", "--url", "--connect", "--json")
"""Options of this command, which it takes before the program only."""
Url = Annotated[
    str, typer.Option("--url", help="Address of NAOqi; a server that answers there is used.", metavar="URL")
]
PLAY = Path(__file__).parents[1] / "naoqi_programs" / "choregraphe" / "play.py"


def run_naoqi(
    program: Annotated[Path, typer.Argument(help="The program, Python 2 or 3.", metavar="PROGRAM.py")],
    arguments: Annotated[
        list[str] | None, typer.Argument(help="Its own arguments and options.", metavar="[ARGS]")
    ] = None,
    robot: options.Body = None,
    url: Url = DEFAULT_URL,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Run a program written for NAOqi, unchanged: `naoqi`, `almath` and `qi` are there.

    Example: nao-hil run-naoqi hello.py --ip 127.0.0.1

    Starts an emulated robot and `serve naoqi` when none runs, and ends with the program's exit code. Any
    address in the program leads to this robot. Options of this command come before the program.
    """
    load_body(robot or BODY)
    compiled = program_code(program)
    arguments = arguments or []
    given = {argument.partition("=")[0] for argument in arguments}
    for option in filter(given.__contains__, OWN_OPTIONS):
        text = f"{option} after the program is the program's own; before it, it is an option of run-naoqi."
        print(f"warning: {printable(text)}", file=sys.stderr, flush=True)
    code, started = run_program(program, compiled, arguments, robot, url, connect)
    return Answer({"exit_code": code, "started": started}, code=code)


def run_program(
    program: Path, compiled: CodeType, arguments: list[str], robot: str | None, url: str, connect: str
) -> tuple[int, list[str]]:
    """Run a program at a served robot; robot and server are started where they are missing.

    Args:
        program: its file.
        compiled: its code.
        arguments: its own.
        robot: body of a robot that is started; None: a V5.
        url: of NAOqi.
        connect: Zenoh endpoint of the robot.

    Returns:
        The program's exit code, and the names of the started processes.

    Raises:
        LinkError: qi is not there, or a process did not start.
        ConfigurationError: not an address.
    """
    require_qi()
    host, port = check_url(url)
    stop = threading.Event()
    with ExitStack() as ends:
        folder = Path(ends.enter_context(tempfile.TemporaryDirectory(prefix="nao-hil-naoqi-")))
        started = []
        code_file = folder / "code"
        code_file.write_bytes(marshal.dumps(compiled))
        with _alone(port):
            if not _answers(host, port):
                for name, words in _missing(robot, url, connect, folder):
                    child = Child(name, words, folder)
                    ends.callback(child.end, GRACE)
                    started.append(child)
                with open_console().status("starting the robot"):
                    # the port is open before all services are there
                    _await(lambda: f"is served at {url}" in started[-1].stderr, started)
        process = subprocess.Popen(
            command(code_file, program, arguments),
            env=os.environ | {ADDRESS: url, "PYTHONPATH": os.pathsep.join(p or os.getcwd() for p in sys.path)},
        )
        on_signals(stop.set)
        deadline = math.inf
        while process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
            if stop.is_set() and deadline == math.inf:
                process.terminate()
                deadline = time.monotonic() + FAREWELL
            if started:
                _print_reports(started[-1])
        if process.poll() is None:
            process.kill()
        code = process.wait()
    code = 128 - code if code < 0 else code
    return code, [child.name for child in started]


@contextmanager
def _alone(port: int) -> Iterator[None]:
    """Wait for other programs of this user that look for a server at this port or start one."""
    import fcntl  # late: only where qi is

    path = Path(tempfile.gettempdir()) / f"nao-hil-naoqi-{os.getuid()}-{port}.lock"
    with path.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _missing(robot: str | None, url: str, connect: str, folder: Path) -> list[tuple[str, list[str]]]:
    """Name and command of each process that does not run yet."""
    kind, _, place = split_endpoint(connect)[0].partition("/")
    host, _, port = place.rpartition(":")
    server = ("server", ["serve", "naoqi", "--listen", url, "--connect", connect])
    if kind in ("tcp", "tls", "ws") and port.isdecimal() and _answers(host, int(port)):
        return [server]
    body = robot or BODY
    return [("robot", ["emulate", "--robot", body, "--listen", connect, "--out", str(folder / "run")]), server]


def _answers(host: str, port: int) -> bool:
    try:
        socket.create_connection((host, port), timeout=1.0).close()
    except OSError:
        return False
    return True


def _print_reports(server: Child) -> None:
    """Print the texts that the robot has spoken and the warnings since the last call."""
    for line in server.new_lines():
        if found := _REPORTED.search(line):
            print(printable(found[0]), file=sys.stderr, flush=True)


def _await(ready: Callable[[], bool], children: list[Child]) -> None:
    """Wait until it is ready.

    Raises:
        LinkError: a process ended, or it takes too long.
    """
    deadline = time.monotonic() + START
    while not ready():
        for child in children:
            if not child.running:
                raise LinkError(f"the {child.name} did not start: {child.end(GRACE).error}")
        if time.monotonic() > deadline:
            raise LinkError(f"the robot was not served within {START:g} s.")
        time.sleep(0.1)


def run_choregraphe(
    project: Annotated[
        Path, typer.Argument(help="A .xar or .pml file, or the folder of one.", metavar="PROJECT")
    ],
    behaviour: Annotated[
        str | None,
        typer.Option("--behavior", help="Which behaviour of several: its folder's name.", metavar="NAME"),
    ] = None,
    idle: Annotated[
        float,
        typer.Option("--idle", help="Seconds without anything running, to its end.", min=0.1, metavar="S"),
    ] = 10.0,
    robot: options.Body = None,
    url: Url = DEFAULT_URL,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Play a behaviour of Choregraphe: script boxes, timelines and flow diagrams; then list the parts left out.

    Example: nao-hil run-choregraphe my_project/my_project.pml

    It ends when the behaviour's onStopped is reached, or when nothing has run for a
    while. Exit code 1: a part is left out.
    """
    load_body(robot or BODY)
    file = _chosen(behaviours(project), behaviour)
    read_behaviour(file)
    with tempfile.TemporaryDirectory(prefix="nao-hil-choregraphe-") as folder:
        report = Path(folder) / "report.json"
        code, started = run_program(
            PLAY, program_code(PLAY), [str(file), str(report), f"{idle:g}"], robot, url, connect
        )
        could_not = json.loads(report.read_text()) if report.is_file() else []
    for sentence in could_not:
        print(f"not done: {printable(sentence)}", file=sys.stderr)
    code = code or int(bool(could_not))
    return Answer({"exit_code": code, "could_not": could_not, "started": started}, code=code)


def _chosen(files: list[Path], name: str | None) -> Path:
    named = {file.parent.name: file for file in files}
    if name is None and len(files) == 1:
        return files[0]
    if name is None or name not in named:
        what = "has several behaviours" if name is None else f"has no behaviour {name!r}"
        raise ConfigurationError(f"The project {what}; name one with --behavior: {', '.join(named)}.")
    return named[name]
