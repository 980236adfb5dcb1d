"""`nao-hil serve naoqi` and `nao-hil bridge naoqi`: both ends of NAOqi."""

from __future__ import annotations

import sys
import tempfile
import threading
from pathlib import Path
from typing import Annotated

import typer

from bridge.adapters.naoqi.qi_library import DEFAULT_URL, check_url, require_qi
from bridge.adapters.naoqi.real_robot import LOOK_AHEAD, NaoqiBridge
from bridge.adapters.robot_bridge import BridgeSettings
from bridge.errors import ConfigurationError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, ControllerLink
from bridge.realtime import CONTROLLER_PRIORITY, ROBOT_PRIORITY
from bridge.types import Vec3
from bridge.validation import unknown_name
from nao_hil import __version__
from nao_hil.cli import options
from nao_hil.cli.console import log_to_stderr, print_json
from nao_hil.cli.signals import on_signals, stop_event
from nao_hil.runs.config import run_config
from nao_hil.runs.supervisor import Child

GRACE = 5.0
"""s a walker has to end by itself."""
SWITCH_INTERVAL = 0.0005
"""s for which a call may hold up a cycle; Python's own 5 ms are half of one."""


class ServingWalker:
    """`nao-hil walk --serve --standby` as a child process."""

    def __init__(self, name: str, connect: str, gait: str) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="nao-hil-walker-")
        arguments = ["walk", "--serve", "--standby", "--name", name, "--connect", connect, "--gait", gait]
        self._child = Child("walker", arguments, Path(self._folder.name))

    @property
    def running(self) -> bool:
        """Whether it has not ended."""
        return self._child.running

    def end(self) -> str:
        """Ask it to end, and wait for that; the sentence of the error that it ended with, or nothing."""
        asked = self._child.running
        outcome = self._child.end(GRACE)
        self._folder.cleanup()
        return "" if asked else outcome.error


def serve(
    url: Annotated[
        str, typer.Option("--listen", help="Address that NAOqi programs connect to.", metavar="URL")
    ] = DEFAULT_URL,
    gait: Annotated[
        str,
        typer.Option(
            "--gait", help="Gait of moveTo, moveToward and move: a name of `nao-hil gaits`.", metavar="GAIT"
        ),
    ] = "omni",
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
    realtime_priority: options.RealtimePriority = True,
    as_json: options.Json = False,
) -> int:
    """Let any robot on the link pose as a NAOqi robot: programs written for NAOqi connect with qi.

    Example: nao-hil serve naoqi --listen tcp://127.0.0.1:9559
    """
    # Imported late: all commands would wait for them, scipy among them.
    from bridge.adapters.naoqi.server import NaoqiServer
    from walker.gaits import GAITS

    if gait not in GAITS:
        raise ConfigurationError(unknown_name("gait", gait, GAITS))

    require_qi()
    log_to_stderr()
    stop = threading.Event()
    sys.setswitchinterval(SWITCH_INTERVAL)
    with ControllerLink(name, connect, "naoqi", direct=True) as link:

        def end() -> None:
            stop.set()
            link.wake()

        on_signals(end)
        server = NaoqiServer(
            link,
            url,
            gait,
            _full(gait),
            lambda: ServingWalker(name, connect, gait),
            stop.is_set,
            CONTROLLER_PRIORITY if realtime_priority else None,
        )
        server.run()
    if as_json:
        print_json({"calls": server.calls})
    return 0


def _full(gait: str) -> Vec3:
    """Full speed of a gait; the gait's own where it walks straight ahead."""
    # Imported late: only a served robot that walks needs the walker's packages.
    from walker.gaits import gait_parameters

    parameters = gait_parameters(gait)
    return parameters.limits.max_velocity if parameters.limits else parameters.velocity


def bridge(
    url: Annotated[
        str, typer.Option("--url", help="Address of the robot's NAOqi, tcp://HOST:9559.", metavar="URL")
    ],
    name: options.Name = DEFAULT_ROBOT,
    listen: options.Listen = DEFAULT_ENDPOINT,
    robot: options.Body = None,
    look_ahead: Annotated[
        float,
        typer.Option(
            "--look-ahead",
            help="Milliseconds from a frame to the time of the command that answers it: as long as the network "
            "may take. It delays every motion.",
            metavar="MS",
        ),
    ] = 1000.0 * LOOK_AHEAD,
    dry_run: options.DryRun = False,
    realtime_priority: options.RealtimePriority = True,
    config: options.Config = None,
    as_json: options.Json = False,
) -> int:
    """Put a real V3, V4 or V5 on the link: it starts disarmed, see `nao-hil arm`.

    Example: nao-hil bridge naoqi --url tcp://192.168.1.7:9559
    """
    check_url(url)
    require_qi()
    run = run_config(config, robot=robot)
    settings = BridgeSettings(
        robot=name,
        listen=listen,
        software=f"nao-hil {__version__}",
        body=run.robot if robot is not None else None,
        guard=run.guard,
        dry_run=dry_run,
        priority=ROBOT_PRIORITY if realtime_priority else None,
    )
    log_to_stderr()
    stop = stop_event()
    bridged = NaoqiBridge(url, look_ahead / 1000.0, settings, stop).run()
    if as_json:
        print_json(bridged)
    return 0
