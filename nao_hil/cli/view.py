"""`nao-hil view`: the live page."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.cli.signals import stop_event
from nao_hil.runs.folder import recording_of
from nao_hil.runs.supervisor import SUPERVISED
from nao_hil.view.access import open_door
from nao_hil.view.child import DEFAULT_HOST, DEFAULT_PORT, READY
from nao_hil.view.page import page, recorded_page, world_page, world_recordings

RUN_ENDS = "`nao-hil up` has ended the run. Look at it again: nao-hil view --replay RUN."
PAGE_ENDS = "The page's server was ended; the robot may still move."
NICENESS = 10
"""The page gives way to the real-time loops of robot and walker."""


def view(
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
    port: options.Port = DEFAULT_PORT,
    host: Annotated[
        str,
        typer.Option("--host", help="Address the page listens on; beyond loopback with TLS and a token."),
    ] = DEFAULT_HOST,
    replay: Annotated[
        list[Path] | None,
        typer.Option(
            "--replay",
            help="Show a recording, or that of a run's folder (with all robots of a world), instead; given "
            "twice: two runs side by side.",
            metavar="FILE",
        ),
    ] = None,
    run: Annotated[
        Path | None,
        typer.Option("--run", help="Folder of the robot's run, for downloads of its recording.", metavar="DIR"),
    ] = None,
) -> int:
    """Show a robot, emulated or real, or a recording, in the browser; ends with Ctrl-C.

    Example: nao-hil view --replay runs/20260101T120000Z/frames.mcap
    """
    os.nice(NICENESS)  # of this thread, and of those that it starts from here on
    replay = replay or []
    stop = stop_event()
    console = open_console()
    door = open_door(host)
    from nao_hil.view.server import PageServer  # imported late: the walker's plans come with it

    # raises before there is a server
    shown = _recorded(replay, name) if replay else page(f"nao-hil: {name}")
    server = PageServer(host, port, door.access, door.tls)
    server.show(*shown)
    console.print(f"{READY} {door.address(host, port)}", soft_wrap=True)
    if door.fingerprint:
        console.print(
            "Its certificate signs itself: the browser warns, and shows this SHA-256 fingerprint:\n"
            f"{door.fingerprint}",
            soft_wrap=True,
        )
    if replay:
        stop.wait()
    else:
        from nao_hil.view.follow import LinkFollower  # imported late: the page is served meanwhile

        LinkFollower(server, name, connect, stop, run).run()
    supervised = SUPERVISED in os.environ and not replay
    server.close(RUN_ENDS if supervised else PAGE_ENDS, run=supervised)
    return 0


def _recorded(runs: list[Path], name: str) -> tuple[str, str]:
    """The page of a run, of two side by side, or of a world's run, and its policy."""
    recordings = [recording_of(run) for run in runs]
    world = world_recordings(runs[0]) if len(runs) == 1 and not recordings[0].exists() else {}
    return world_page(world, name) if world else recorded_page(recordings)
