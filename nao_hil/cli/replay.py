"""`nao-hil replay`: a recording as a robot on the wire."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.recording.playback import recorded_config
from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.cli.signals import stop_event


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
    as_json: options.Json = False,
) -> int:
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
    if as_json:
        played_back = {"frames": frames, "position": player.position, "config": recorded_config(file)}
        print(json.dumps(played_back), flush=True)
    return 130 if stop.is_set() and not loop else 0
