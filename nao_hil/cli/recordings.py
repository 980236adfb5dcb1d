"""`nao-hil record`, `replay` and `info`: recordings of a robot and its controller."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from bridge.body import body_of
from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.recording.playback import recorded_config
from bridge.recording.recorder import Recorder
from nao_hil.cli import options
from nao_hil.cli.console import Answer, log_to_stderr, open_console
from nao_hil.cli.signals import stop_event
from nao_hil.runs.folder import robot_scene

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
) -> Answer | int:
    """Record any robot, emulated or real, from its appearance until Ctrl-C.

    The file stays readable if this is killed. A robot that restarts gets a file of its own.

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
    log_to_stderr()
    stop = stop_event()
    waiting = f"waiting for robot `{name}` at {connect}"
    if not console.is_terminal:  # where `status` shows nothing
        console.print(waiting)
    with Capture(name, connect) as capture, console.status(waiting) as status:
        info = capture.wait_robot(stop.is_set)
        if info is None:
            return 130
        with Recorder(
            out or free_name(Path(), name), described(info), robot_scene(body_of(info.body, info.sheet))
        ) as recorder:
            console.print(f"recording `{name}` ({info.body}, {info.side}) to {recorder.paths[0]}")
            while not stop.is_set() and (duration is None or capture.seconds < duration):
                capture.record(recorder, _TAKE)
                status.update(f"{capture.seconds:.1f} s, {sum(capture.counts.values())} messages")
    files = [str(path) for path in recorder.paths]
    console.print(f"{capture.seconds:.2f} s of robot time in {', '.join(files)}")
    result = {"files": files, "seconds": capture.seconds, "messages": capture.counts}
    return Answer(result | {"refused": capture.refused})


def replay(
    file: options.Recording,
    speed: Annotated[
        float, typer.Option("--speed", help="Robot time per wall-clock time.", min=0.01, max=1000.0)
    ] = 1.0,
    begin: options.Begin = 0.0,
    end: options.End = None,
    loop: Annotated[bool, typer.Option("--loop", help="Begin again at the end, until Ctrl-C.")] = False,
    robot: options.Body = None,
    name: options.Name = DEFAULT_ROBOT,
    listen: options.Listen = DEFAULT_ENDPOINT,
) -> Answer:
    """Play a recording back onto the wire, as a robot that can be listened to and takes no commands.

    Example: nao-hil replay runs/20260101T120000Z/frames.mcap --speed 0.25

    Example: nao-hil replay walk.mcap --from 12 --to 15 --loop
    """
    from nao_hil.runs.replay import Replay

    options.check_stretch(begin, end)
    console = open_console()
    stop = stop_event()
    last = float("inf") if end is None else end
    frames = 0
    with Replay(file, name, listen, robot) as player, console.status("playing") as status:
        console.print(f"robot `{name}` ({player.info.body}, a recording) at {listen}")

        def wait(seconds: float) -> bool:
            status.update(f"{player.position:.2f} s")
            return stop.wait(seconds) if seconds > 0.0 else stop.is_set()

        while not stop.is_set():
            played = player.play(wait, speed=speed, begin=begin, end=last)
            if not played and not stop.is_set():
                raise ConfigurationError(f"{file}: holds no sensor frame {options.stretch(begin, end)}.")
            frames += played
            if not loop:
                break
    played_back = {"frames": frames, "position": player.position, "config": recorded_config(file)}
    return Answer(played_back, code=130 if stop.is_set() and not loop else 0)


def info(file: options.Recording) -> Answer:
    """Show the content of a recording: robot, run, times, messages, outcome and first symptom.

    A truncated recording is shown too.

    Example: nao-hil info runs/20260101T120000Z/frames.mcap
    """
    from nao_hil.analysis.inspection import inspect

    with open_console().status(f"reading {file}"):
        contents = inspect(file)
    table = Table(title=str(file), show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    for name, value in _rows(contents):
        table.add_row(name, value)
    return Answer(contents, table)


def _rows(c: Any) -> list[tuple[str, str]]:
    config = dict(c.config) if isinstance(c.config, dict) else {}
    if not c.messages["walk/telemetry"]:
        config.pop("gait", None)  # the run's setting, but another controller moved the robot
    rows = [(key, str(config[key])) for key in _NAMED if config.get(key) not in (None, "", {})]
    ending = "whole" if c.complete else "cut off: reads up to its last whole chunk"
    if c.after:
        ending = f"whole, but followed by {c.after} bytes that are not read, as of a second file joined to it"
    rows += [
        ("file", ending),
        ("robot time", f"{c.begin:.2f} to {c.end:.2f} s"),
        ("cycles", f"{c.cycles}, {c.gaps} not recorded, {c.cycles_missed} missed by the controller"),
        ("messages", ", ".join(f"{topic} {n}" for topic, n in c.messages.items() if n) or "none"),
        ("notices", ", ".join(f"{code} {n}" for code, n in c.notices.items()) or "none"),
        (
            "steps",
            str(c.steps) if c.messages["walk/telemetry"] else "unknown: the controller sends no telemetry",
        ),
        ("largest torso tilt", f"{math.degrees(c.torso_max):.2f} deg"),
    ]
    if c.fell is not None:
        rows += [("distance", f"{c.distance:.3f} m"), ("fell", "yes" if c.fell else "no")]
    if c.diagnosis is not None:
        rows.append(("what went wrong", c.diagnosis))
    if c.fall_cause:
        rows.append(("the walker's reason", c.fall_cause))
    return [*rows, ("sha256 of the frames", c.frames_sha256)]


_NAMED = ("robot", "wear", "scenario", "gait", "mode", "seed", "name", "side", "software")
"""Keys of a run's configuration that are shown."""
