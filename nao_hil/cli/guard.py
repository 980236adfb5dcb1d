"""`nao-hil stop` and `nao-hil arm`: the emergency stop, and the way out of it."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.client import GuardClient
from bridge.messages.guard import GuardStatus
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console

_WHO = "nao-hil on the command line"


def stop(
    limp: Annotated[
        bool,
        typer.Option("--limp", help="Let go at once instead of crouching first; a robot that stands falls."),
    ] = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Emergency stop: the robot crouches, lets go, and takes no command until `nao-hil arm`. Needs no lease.

    Example: nao-hil stop --connect tcp/192.168.1.7:7447
    """
    with GuardClient(name, connect) as guard:
        return _show(guard.stop("limp" if limp else "crouch", _WHO))


def arm(
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask; for scripts.")] = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Let a robot take commands: a real one after its start, any one after an emergency stop.

    Example: nao-hil arm --yes --connect tcp/192.168.1.7:7447
    """
    with GuardClient(name, connect) as guard:
        if not yes:
            _confirm(guard, name)
        return _show(guard.arm(_WHO))


def _confirm(guard: GuardClient, name: str) -> None:
    """Ask the user to confirm, after naming the robot and its controller.

    Raises:
        ConfigurationError: there is no terminal, or the answer is no.
    """
    if not sys.stdin.isatty():
        raise ConfigurationError("`nao-hil arm` asks before it arms; without a terminal, say --yes.")
    info, status, holder = guard.info(), guard.status(), guard.holder()
    who = f"controller `{holder}` holds it and may move it at once" if holder else "no controller holds it yet"
    open_console().print(
        f"Robot `{name}` ({info.body}, {info.side}): {status.text} When armed: {who}.",
        highlight=False,
        soft_wrap=True,
    )
    if not typer.confirm("Stand clear, or hold it. Arm?", err=True):
        raise ConfigurationError("not armed.")


def _show(status: GuardStatus) -> Answer:
    open_console().print(status.text, highlight=False, soft_wrap=True)
    return Answer(status)
