"""One command for every robot of a link: a process each, so that none holds up another's cycle."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Final

import typer

from bridge.errors import ConfigurationError, LinkError, RobotSilent
from bridge.link import DEFAULT_ROBOT
from bridge.link.client import link_robots
from nao_hil.cli.console import Answer, open_console
from nao_hil.cli.signals import stop_event
from nao_hil.runs.supervisor import Child

Every = Annotated[
    bool, typer.Option("--all", help="Every robot that is on the link now, a process each; without --name.")
]
_LOOK: Final = 0.2
"""s between two looks at the processes."""
_SETTLED: Final = 0.5
"""s without a new robot after which all robots of a world are taken to be there."""
_GRACE: Final = 30.0
"""s that a process has to end by itself."""


def for_every_robot(
    connect: str, name: str, arguments: Callable[[int, str], tuple[str, list[str]]]
) -> Answer | int:
    """Run a command for each robot of a link until a signal comes.

    Args:
        connect: Zenoh endpoint of the link; waits until robots are there.
        name: Of --name, which all robots leave no room for.
        arguments: Place of a robot, and arguments of its command, by its number from 0 and its id; `--name`,
            `--connect` and `--json` are added.

    Raises:
        ConfigurationError: a name was given.
        LinkError: processes ended by themselves; raised at the end, which the others do not bring about.
    """
    if name != DEFAULT_ROBOT:
        raise ConfigurationError(f"--all serves every robot, --name {name} one: leave one of them out.")
    stop = stop_event()
    names = _all_robots(connect, stop)
    if stop.is_set():
        return 130
    with tempfile.TemporaryDirectory(prefix="nao-hil-") as folder:
        children = []
        for i, robot in enumerate(names):
            place, words = arguments(i, robot)
            open_console().print(f"{robot}: {place}", soft_wrap=True)
            command = [*words, "--name", robot, "--connect", connect, "--json"]
            children.append(Child(robot, command, Path(folder)))
        ended: list[Child] = []
        while not stop.wait(_LOOK) and len(ended) < len(children):
            new = [child for child in children if not child.running and child not in ended]
            _show(children)
            for child in new:
                rest = ", ".join(c.name for c in children if c.running) or "none"
                open_console().print(f"{child.name}: has ended; there are still: {rest}")
            ended += new
        for child in children:
            child.ask_to_end()
        outcomes = {child.name: child.end(_GRACE) for child in children}
        _show(children)
    answer = {"robots": {name: outcome.result for name, outcome in outcomes.items()}}
    why = " ".join(f"Robot `{child.name}`: {outcomes[child.name].error}" for child in ended)
    return Answer(answer, error=LinkError(why) if why else None)


def _all_robots(connect: str, stop: threading.Event) -> list[str]:
    """Ids of the robots, once there are some and no more come; empty: stopped."""
    console, found = open_console(), list[str]()
    while not stop.is_set():
        try:
            names = link_robots(connect, 0.0)
        except RobotSilent:
            names = []
        if names and names == found:
            return names
        if not names and not found:
            console.print(f"waiting for robots at {connect}")
        found = names
        stop.wait(_SETTLED)
    return []


def _show(children: list[Child]) -> None:
    """Print what the processes have reported, each line after its robot."""
    for child in children:
        for line in child.new_lines():
            open_console().print(f"{child.name}: {line}", soft_wrap=True)
