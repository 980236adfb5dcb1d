"""`nao-hil walk`: the walker's process."""

from __future__ import annotations

import json
import logging
import threading
from typing import Annotated

import msgspec
import typer
from rich.console import Console
from rich.logging import RichHandler

from bridge.datasheet import Body
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, ControllerLink
from bridge.realtime import CONTROLLER_PRIORITY
from lab.cli import options
from lab.cli.signals import on_signals
from lab.config import RunConfig, run_config
from walker.controller import Controller, WalkOrder
from walker.gait import gait_parameters, make_gait
from walker.parameters import controller_parameters
from walker.process import MakeController, WalkerProcess
from walker.walkable import check_walkable


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
    realtime_priority: options.RealtimePriority = True,
    config: options.Config = None,
    as_json: options.Json = False,
) -> int:
    """Walk the robot at the other end of the link, emulated or real; waits for it if it is not there yet.

    Example: nao-hil walk --gait static --steps 20 --connect tcp/192.168.1.7:7447
    """
    settings = run_config(
        config, robot=robot, gait=gait, torso=torso, admittance=admittance, steps=steps, duration=duration
    )
    logging.basicConfig(
        level=logging.INFO,
        format="%(message)s",
        handlers=[RichHandler(console=Console(stderr=True), show_path=False)],
    )
    stop = threading.Event()
    make = controller_maker(settings)  # a wrong parameter is told before anyone waits
    with ControllerLink(name, connect, controller) as link:

        def end() -> None:
            stop.set()
            link.wake()

        on_signals(end)
        body = settings.robot if robot is not None or config is not None else None
        priority = CONTROLLER_PRIORITY if realtime_priority else None
        result = WalkerProcess(link, make, body, stop.is_set, priority).run()
    if as_json:
        print(json.dumps(msgspec.to_builtins(result)), flush=True)
    if result.fell:
        return 1
    return 0 if result.done else 130


def controller_maker(settings: RunConfig) -> MakeController:
    """How to make the controller of a run, for the robot that turns out to be there.

    Raises:
        ConfigurationError: a wrong parameter of the gait or the controller.
    """
    parameters = gait_parameters(settings.gait, settings.parameters)
    stabilisers = controller_parameters(settings.gait, settings.controller)
    order = WalkOrder(steps=settings.steps, duration=settings.duration or float("inf"))

    def make(body: Body, cycle: float) -> Controller:
        check_walkable(body, make_gait(settings.gait, parameters, body))
        return Controller(body, make_gait(settings.gait, parameters, body), order, cycle, stabilisers)

    return make
