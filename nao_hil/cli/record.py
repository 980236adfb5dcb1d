"""`nao-hil record`: write down what a robot and its controller say."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Annotated

import typer

from bridge.body import load_body
from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.recording.recorder import Recorder
from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.cli.signals import stop_event
from nao_hil.runs.description import robot_scene

_TAKE = 0.2
"""s between two looks whether to end."""


def record(
    out: Annotated[
        Path | None,
        typer.Option("--out", help="File to write; default NAME-TIME.mcap in this folder.", metavar="FILE"),
    ] = None,
    duration: Annotated[
        float | None,
        typer.Option("--duration", help="Robot time to record, s; default: until Ctrl-C.", min=0.0),
    ] = None,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
    as_json: options.Json = False,
) -> int:
    """Record any robot, emulated or real, until Ctrl-C; waits for it if it is not there yet.

    What is on disk stays readable if this is killed. A robot that begins anew gets a file of its own.

    Example: nao-hil record --out walk.mcap --duration 60

    Example: nao-hil record --name bridge --connect tcp/192.168.1.7:7447
    """
    from nao_hil.runs.capture import Capture, described, free_name

    if out is not None and not os.access(out.parent, os.W_OK):
        why = "not writable" if out.parent.is_dir() else "no such folder"
        raise ConfigurationError(f"{out}: cannot be written ({why}); give another place with --out.")
    if out is not None and out.exists():
        raise ConfigurationError(f"{out}: there is such a file already; give another with --out, or remove it.")
    console = open_console()
    stop = stop_event()
    waiting = f"waiting for robot `{name}` at {connect}"
    if not console.is_terminal:  # where `status` shows nothing
        console.print(waiting)
    with Capture(name, connect) as capture, console.status(waiting) as status:
        info = capture.wait_robot(stop.is_set)
        if info is None:
            return 130
        with Recorder(
            out or free_name(Path(), name), described(info), robot_scene(load_body(info.body))
        ) as recorder:
            console.print(f"recording `{name}` ({info.body}, {info.side}) to {recorder.paths[0]}")
            while not stop.is_set() and (duration is None or capture.seconds < duration):
                capture.record(recorder, _TAKE)
                status.update(f"{capture.seconds:.1f} s, {sum(capture.counts.values())} messages")
    files = [str(path) for path in recorder.paths]
    console.print(f"{capture.seconds:.2f} s of robot time in {', '.join(files)}")
    if as_json:
        result = {"files": files, "seconds": capture.seconds, "messages": capture.counts}
        print(json.dumps(result | {"refused": capture.refused}), flush=True)
    return 0
