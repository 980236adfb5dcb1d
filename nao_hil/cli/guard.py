"""`nao-hil stop` and `nao-hil arm`: the emergency stop, and the way out of it."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Annotated

import typer

from bridge.errors import ConfigurationError, LinkError, NaoHilError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.client import GuardClient, link_robots
from bridge.messages.guard import GuardStatus
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console

_WHO = "nao-hil on the command line"
Robot = Annotated[str, typer.Argument(help="Robot id, as --name.", metavar="NAME", show_default=False)]


def stop(
    robot: Robot = "",
    every: Annotated[bool, typer.Option("--all", help="Stop all robots of the link.")] = False,
    limp: Annotated[
        bool,
        typer.Option("--limp", help="Let go at once instead of crouching first; a robot that stands falls."),
    ] = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Emergency stop: the robot crouches, lets go, and takes no command until `nao-hil arm`. Needs no lease.

    Example: nao-hil stop --connect tcp/192.168.1.7:7447

    Example: nao-hil stop --all
    """
    if every and robot:
        raise ConfigurationError(f"--all stops every robot, {robot} too; leave one of both out.")
    names = link_robots(connect) if every else [_robot_id(robot, name)]

    def stopped(who: str) -> GuardStatus | NaoHilError:
        try:
            with GuardClient(who, connect) as guard:
                return guard.stop("limp" if limp else "crouch", _WHO)
        except NaoHilError as error:
            return error

    with ThreadPoolExecutor(len(names)) as pool:  # all at once: one that does not answer holds up no other
        results = dict(zip(names, pool.map(stopped, names), strict=True))
    done = {who: result for who, result in results.items() if isinstance(result, GuardStatus)}
    failed = [result for result in results.values() if isinstance(result, NaoHilError)]
    if not every and failed:
        raise failed[0]
    if not every:
        return _show(done[names[0]])
    for who, status in done.items():
        open_console().print(f"{who}: {status.text}", soft_wrap=True)
    error = LinkError(" ".join(map(str, failed))) if failed else None
    return Answer({"robots": done}, error=error)


def _robot_id(robot: str, name: str) -> str:
    """The robot that is named, by the argument or by --name."""
    if robot and name not in (DEFAULT_ROBOT, robot):
        raise ConfigurationError(f"{robot} and --name {name} are two robots; give one, or stop each by itself.")
    return robot or name


def arm(
    robot: Robot = "",
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask; for scripts.")] = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Let a robot take commands: a real one after its start, any one after an emergency stop.

    Example: nao-hil arm --yes --connect tcp/192.168.1.7:7447
    """
    who = _robot_id(robot, name)
    with GuardClient(who, connect) as guard:
        if not yes:
            _confirm(guard, who)
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
        soft_wrap=True,
    )
    if not typer.confirm("Stand clear, or hold it. Arm?", err=True):
        raise ConfigurationError("not armed.")


def _show(status: GuardStatus) -> Answer:
    open_console().print(status.text, soft_wrap=True)
    return Answer(status)
