"""`nao-hil run-choregraphe`: a behaviour of Choregraphe, with robot and server if none runs."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from bridge.adapters.naoqi.qi_library import DEFAULT_URL
from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ENDPOINT
from nao_hil.cli import options
from nao_hil.cli.run_naoqi import Url, run_program
from nao_hil.naoqi_programs.choregraphe.project import behaviours, read_behaviour

PLAY = Path(__file__).parents[1] / "naoqi_programs" / "choregraphe" / "play.py"


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
    as_json: options.Json = False,
) -> int:
    """Play a behaviour of Choregraphe: script boxes, timelines and flow diagrams; then list what was not done.

    Example: nao-hil run-choregraphe my_project/my_project.pml

    It ends when the behaviour's onStopped is reached, or when nothing has run for a
    while. Exit code 1: something was not done.
    """
    file = _chosen(behaviours(project), behaviour)
    read_behaviour(file)
    with tempfile.TemporaryDirectory(prefix="nao-hil-choregraphe-") as folder:
        report = Path(folder) / "report.json"
        code, started = run_program(PLAY, [str(file), str(report), f"{idle:g}"], robot, url, connect)
        could_not = json.loads(report.read_text()) if report.is_file() else []
    for sentence in could_not:
        print(f"not done: {sentence}", file=sys.stderr)
    code = code or int(bool(could_not))
    if as_json:
        print(json.dumps({"exit_code": code, "could_not": could_not, "started": started}), flush=True)
    return code


def _chosen(files: list[Path], name: str | None) -> Path:
    named = {file.parent.name: file for file in files}
    if name is None and len(files) == 1:
        return files[0]
    if name is None or name not in named:
        what = "has several behaviours" if name is None else f"has no behaviour {name!r}"
        raise ConfigurationError(f"The project {what}; name one with --behavior: {', '.join(named)}.")
    return named[name]
