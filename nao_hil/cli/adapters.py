"""`nao-hil serve` and `nao-hil bridge`: both ends of LoLA's socket and of NAOqi, and the GameController."""

from __future__ import annotations

import sys
import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from bridge.adapters.gamecontroller.packets import DATA_PORT, RETURN_PORT
from bridge.adapters.gamecontroller.server import GameControllerServer, open_sockets
from bridge.adapters.lola.address import listen, parse_address, remove
from bridge.adapters.lola.bridge import LolaBridge
from bridge.adapters.lola.codec import DEFAULT_SOCKET
from bridge.adapters.lola.packets import Identity
from bridge.adapters.lola.server import LolaServer
from bridge.adapters.naoqi.qi_library import DEFAULT_URL, check_url, require_free, require_qi
from bridge.adapters.naoqi.real_robot import LOOK_AHEAD, NaoqiBridge
from bridge.adapters.robot_bridge import BridgeSettings
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, ControllerLink
from bridge.link.certificates import OPEN_MARK
from bridge.link.session import split_open
from bridge.realtime import CONTROLLER_PRIORITY, ROBOT_PRIORITY
from bridge.types import Vec3
from nao_hil import __version__
from nao_hil.cli import options
from nao_hil.cli.console import Answer, log_to_stderr
from nao_hil.cli.every_robot import Every, for_every_robot
from nao_hil.cli.signals import stop_event
from nao_hil.runs.config import RunConfig, run_config
from nao_hil.runs.supervisor import Child

GRACE = 30.0
"""s a walker has to end by itself."""
SWITCH_INTERVAL = 0.0005
"""s for which a call may hold up a cycle; Python's own 5 ms are half of one."""
_ANYBODY = Identity()
Socket = Annotated[
    str, typer.Option("--socket", help="LoLA's socket: a path, or HOST:PORT.", metavar="PATH|HOST:PORT")
]


def serve_lola(
    socket: Socket = DEFAULT_SOCKET,
    every: Every = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
    body_id: Annotated[
        str, typer.Option("--body-id", help="The robot's body id, 20 characters.", metavar="ID")
    ] = _ANYBODY.body_id,
    head_id: Annotated[
        str, typer.Option("--head-id", help="The robot's head id, 20 characters.", metavar="ID")
    ] = _ANYBODY.head_id,
    realtime_priority: options.RealtimePriority = True,
) -> Answer | int:
    """Let any robot on the link pose as a V6: programs written for LoLA connect to the socket.

    Beyond loopback the address ends with `#open`: everyone on the network can then move the robot.
    With --all each robot has a socket PATH-NAME, or ports count up from HOST:PORT in the order of the names.

    Example: nao-hil serve lola --socket /tmp/robocup

    Example: nao-hil serve lola --all
    """
    identity = Identity(body_id=body_id, head_id=head_id).check()
    address = parse_address(split_open(socket, lambda plain: parse_address(plain).host))
    if every:
        mark = OPEN_MARK if socket.endswith(OPEN_MARK) else ""
        ids = ["--body-id", body_id, "--head-id", head_id, *_priority(realtime_priority)]

        def each(i: int, robot: str) -> tuple[str, list[str]]:
            place = f"{address.of(i, robot)}{mark}"
            return place, ["serve", "lola", "--socket", place, *ids]

        return for_every_robot(connect, name, each)
    log_to_stderr()
    stop = stop_event()
    priority = CONTROLLER_PRIORITY if realtime_priority else None
    with ControllerLink(name, connect, "lola", direct=True) as link, listen(address) as listener:
        try:
            served = LolaServer(link, listener, identity, stop, priority).run()
        finally:
            remove(address)
    return Answer(served)


def _priority(wanted: bool) -> list[str]:
    return ["--realtime-priority" if wanted else "--no-realtime-priority"]


def _bridged(
    run: RunConfig, body: str | None, name: str, listen: str, dry_run: bool, priority: bool, **more: Any
) -> BridgeSettings:
    """Settings of a bridge; `body` is None where the robot reports its own."""
    return BridgeSettings(
        robot=name,
        listen=listen,
        software=f"nao-hil {__version__}",
        body=body,
        guard=run.guard,
        dry_run=dry_run,
        priority=ROBOT_PRIORITY if priority else None,
        **more,
    )


def bridge_lola(
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
    body = run.robot if robot is not None else None
    settings = _bridged(run, body, name, listen, dry_run, realtime_priority, mode=run.mode)
    address = parse_address(socket)
    log_to_stderr()
    stop = stop_event()
    bridged = LolaBridge(address, settings, stop).run()
    return Answer(bridged)


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


def serve_naoqi(
    url: Annotated[
        str, typer.Option("--listen", help="Address that NAOqi programs connect to.", metavar="URL")
    ] = DEFAULT_URL,
    gait: Annotated[
        str,
        typer.Option(
            "--gait", help="Gait of moveTo, moveToward and move: a name of `nao-hil gaits`.", metavar="GAIT"
        ),
    ] = "omni",
    every: Every = False,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
    realtime_priority: options.RealtimePriority = True,
    home: Annotated[
        Path | None,
        typer.Option(
            "--home",
            help="Folder for the robot's /home/nao, where alone programs may write; "
            "without it runs/<time>/home.",
            metavar="DIR",
        ),
    ] = None,
) -> Answer | int:
    """Let any robot on the link pose as a NAOqi robot: programs written for NAOqi connect with qi.

    Beyond loopback the address ends with `#open`: everyone on the network can then move the robot.
    With --all ports count up from that of --listen in the order of the names, and each home is DIR/NAME.

    Example: nao-hil serve naoqi --listen tcp://127.0.0.1:9559

    Example: nao-hil serve naoqi --all
    """
    # Imported late: all commands would wait for them, scipy among them.
    from bridge.adapters.naoqi.server import NaoqiServer
    from nao_hil.runs.folder import name_of_now
    from walker.gaits.catalogue import gait_kind

    gait_kind(gait)  # refuses an unknown name before anything has begun
    mark = OPEN_MARK if url.endswith(OPEN_MARK) else ""
    url = split_open(url, lambda plain: check_url(plain)[0])
    require_qi()
    home = home or Path("runs") / name_of_now() / "home"
    if every:
        host, port = check_url(url)

        def each(i: int, robot: str) -> tuple[str, list[str]]:
            place = f"tcp://{host}:{port + i}{mark}"
            words = ["--listen", place, "--home", str(home / robot), "--gait", gait]
            return place, ["serve", "naoqi", *words, *_priority(realtime_priority)]

        return for_every_robot(connect, name, each)
    require_free(url)  # before the link is opened: nothing has to be ended
    log_to_stderr()
    sys.setswitchinterval(SWITCH_INTERVAL)
    priority = CONTROLLER_PRIORITY if realtime_priority else None
    with ControllerLink(name, connect, "naoqi", direct=True) as link:
        stop, walker = stop_event(link.wake), partial(ServingWalker, name, connect, gait)
        server = NaoqiServer(link, url, gait, _full(gait), walker, stop.is_set, home, priority)
        server.run()
    return Answer({"calls": server.calls})


def serve_gamecontroller(
    listen: Annotated[
        str,
        typer.Option("--listen", help="Where the packets of the GameController arrive.", metavar="HOST:PORT"),
    ] = f"127.0.0.1:{DATA_PORT}",
    return_port: Annotated[
        int, typer.Option("--return-port", min=1, max=65535, help="Of the GameController, for return packets.")
    ] = RETURN_PORT,
    connect: options.Connect = DEFAULT_ENDPOINT,
) -> Answer:
    """Let the emulated robots of the link take part in a game of the RoboCup SPL's GameController.

    Beyond loopback the address ends with `#open`: everyone on the network can then call the game.

    Example: nao-hil serve gamecontroller

    Example: nao-hil serve gamecontroller --listen 0.0.0.0:3838#open
    """
    parse = partial(parse_address, path=False)
    address = parse(split_open(listen, lambda plain: parse(plain).host))
    log_to_stderr()
    stop = stop_event()
    with GameControllerServer(connect, open_sockets(address), return_port, stop.is_set) as server:
        return Answer(server.run())


def _full(gait: str) -> Vec3:
    """Full speed of a gait; the gait's own where it walks straight ahead."""
    # Imported late: only a served robot that walks needs the walker's packages.
    from walker.gaits import gait_parameters

    parameters = gait_parameters(gait)
    return parameters.limits.max_velocity if parameters.limits else parameters.velocity


def bridge_naoqi(
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
) -> Answer:
    """Put a real V3, V4 or V5 on the link: it starts disarmed, see `nao-hil arm`.

    Example: nao-hil bridge naoqi --url tcp://192.168.1.7:9559
    """
    check_url(url)
    require_qi()
    run = run_config(config, robot=robot)
    body = run.robot if robot is not None else None
    settings = _bridged(run, body, name, listen, dry_run, realtime_priority)
    log_to_stderr()
    stop = stop_event()
    bridged = NaoqiBridge(url, look_ahead / 1000.0, settings, stop).run()
    return Answer(bridged)
