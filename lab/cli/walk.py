"""`nao-hil walk`: the walker's process."""

from __future__ import annotations

import json
import sys
import threading
from typing import TYPE_CHECKING, Annotated, Final

import msgspec
import typer

from bridge.datasheet import Body
from bridge.errors import LinkError
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, ControllerLink
from bridge.realtime import CONTROLLER_PRIORITY
from bridge.walk import COMMAND
from lab.cli import options
from lab.cli.logs import log_to_stderr
from lab.cli.signals import on_signals
from lab.config import RunConfig, run_config

if TYPE_CHECKING:
    from walker.controller import Controller
    from walker.process import MakeController

SWITCH_INTERVAL: Final = 5e-4
"""s for which a command being checked may hold up a tick; Python's own 5 ms are half a cycle."""


def walk(
    robot: options.Body = None,
    gait: options.Gait = None,
    torso: options.Torso = None,
    admittance: options.Admittance = None,
    steps: options.Steps = None,
    duration: options.Duration = None,
    name: options.Name = DEFAULT_ROBOT,
    connect: options.Connect = DEFAULT_ENDPOINT,
    controller: Annotated[
        str, typer.Option("--controller", help="Name of this controller, shown to others.", metavar="NAME")
    ] = "walker",
    serve: options.Serve = False,
    realtime_priority: options.RealtimePriority = True,
    config: options.Config = None,
    as_json: options.Json = False,
) -> int:
    """Walk the robot at the other end of the link, emulated or real; waits for it if it is not there yet.

    Example: nao-hil walk --gait static --steps 20 --connect tcp/192.168.1.7:7447

    With --serve it stands and waits for `nao-hil drive`, the live page, or your own program (docs/protocol.md).
    """
    # imported late: the walk stands on SciPy, which help and completion need not wait for
    from walker.process import WalkerProcess
    from walker.service import WalkService

    settings = run_config(
        config, robot=robot, gait=gait, torso=torso, admittance=admittance, steps=steps, duration=duration
    )
    log_to_stderr()
    stop = threading.Event()
    # made first, so that a wrong parameter is told before anyone waits
    service = WalkService(settings.gait, settings.parameters, settings.controller) if serve else None
    make = service.make if service is not None else controller_maker(settings)
    with ControllerLink(name, connect, controller) as link:
        if service is not None:
            link.serve(COMMAND, service.answer)
            sys.setswitchinterval(SWITCH_INTERVAL)

        def end() -> None:
            stop.set()
            link.wake()

        on_signals(end)
        body = settings.robot if robot is not None or config is not None else None
        priority = CONTROLLER_PRIORITY if realtime_priority else None
        result = WalkerProcess(link, make, body, stop.is_set, priority, service).run()
    if as_json:
        print(json.dumps(msgspec.to_builtins(result)), flush=True)
    if result.fell:
        return 1
    if result.late and not serve:
        raise LinkError("The link is worse than a walk bears; the robot stands. See docs/weather.md.")
    return 0 if result.done or serve else 130


def controller_maker(settings: RunConfig) -> MakeController:
    """How to make the controller of a run, for the robot that turns out to be there.

    Raises:
        ConfigurationError: a wrong parameter of the gait or the controller.
    """
    from lab.ground import ground_parameters
    from walker.controller import Controller, WalkOrder
    from walker.gait import gait_parameters, make_gait
    from walker.parameters import controller_parameters
    from walker.walkable import check_walkable

    stabilisers = controller_parameters(settings.gait, settings.controller)
    order = WalkOrder(steps=settings.steps, duration=settings.duration or float("inf"))

    gait_parameters(settings.gait, settings.parameters)

    def make(body: Body, cycle: float) -> Controller:
        parameters = gait_parameters(settings.gait, ground_parameters(settings, body))
        check_walkable(body, make_gait(settings.gait, parameters, body))
        return Controller(body, make_gait(settings.gait, parameters, body), order, cycle, stabilisers)

    return make
