"""`nao-hil serve lola` and `nao-hil bridge lola`: both ends of LoLA's socket."""

from __future__ import annotations

from typing import Annotated

import typer

from bridge.adapters.lola.address import listen, parse_address, remove
from bridge.adapters.lola.bridge import LolaBridge
from bridge.adapters.lola.codec import DEFAULT_SOCKET
from bridge.adapters.lola.packets import Identity
from bridge.adapters.lola.server import LolaServer
from bridge.adapters.robot_bridge import BridgeSettings
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, ControllerLink
from bridge.realtime import CONTROLLER_PRIORITY, ROBOT_PRIORITY
from nao_hil import __version__
from nao_hil.cli import options
from nao_hil.cli.console import Answer, log_to_stderr
from nao_hil.cli.signals import stop_event
from nao_hil.runs.config import run_config

_ANYBODY = Identity()
Socket = Annotated[
    str, typer.Option("--socket", help="LoLA's socket: a path, or HOST:PORT.", metavar="PATH|HOST:PORT")
]


def serve(
    socket: Socket = DEFAULT_SOCKET,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
    body_id: Annotated[
        str, typer.Option("--body-id", help="The robot's body id, 20 characters.", metavar="ID")
    ] = _ANYBODY.body_id,
    head_id: Annotated[
        str, typer.Option("--head-id", help="The robot's head id, 20 characters.", metavar="ID")
    ] = _ANYBODY.head_id,
    realtime_priority: options.RealtimePriority = True,
) -> Answer:
    """Let any robot on the link pose as a V6: programs written for LoLA connect to the socket.

    Example: nao-hil serve lola --socket /tmp/robocup
    """
    identity = Identity(body_id=body_id, head_id=head_id).check()
    address = parse_address(socket)
    log_to_stderr()
    stop = stop_event()
    priority = CONTROLLER_PRIORITY if realtime_priority else None
    with ControllerLink(name, connect, "lola", direct=True) as link, listen(address) as listener:
        try:
            served = LolaServer(link, listener, identity, stop, priority).run()
        finally:
            remove(address)
    return Answer(served)


def bridge(
    socket: Socket = DEFAULT_SOCKET,
    name: options.Name = DEFAULT_ROBOT,
    listen: options.Listen = DEFAULT_ENDPOINT,
    robot: options.Body = None,
    mode: options.Mode = None,
    dry_run: options.DryRun = False,
    realtime_priority: options.RealtimePriority = True,
    config: options.Config = None,
) -> Answer:
    """Put a real V6 on the link: it starts disarmed, see `nao-hil arm`. LoLA's socket may be relayed over TCP.

    Example: nao-hil bridge lola --socket 192.168.1.7:10000
    """
    run = run_config(config, robot=robot, mode=mode)
    settings = BridgeSettings(
        robot=name,
        listen=listen,
        software=f"nao-hil {__version__}",
        body=run.robot if robot is not None else None,
        mode=run.mode,
        guard=run.guard,
        dry_run=dry_run,
        priority=ROBOT_PRIORITY if realtime_priority else None,
    )
    address = parse_address(socket)
    log_to_stderr()
    stop = stop_event()
    bridged = LolaBridge(address, settings, stop).run()
    return Answer(bridged)
