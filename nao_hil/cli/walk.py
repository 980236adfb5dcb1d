"""`nao-hil walk`: the walker's process."""

from __future__ import annotations

import logging
import math
import sys
from typing import TYPE_CHECKING, Annotated, Final

import msgspec
import typer

from bridge.body import load_body
from bridge.errors import LinkError, NaoHilError, WalkFailed
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, ControllerLink
from bridge.messages.walk import WALK_COMMAND
from bridge.realtime import CONTROLLER_PRIORITY
from nao_hil.cli import options
from nao_hil.cli.console import Answer, log_to_stderr
from nao_hil.cli.signals import loading, stop_event
from nao_hil.runs.config import RunConfig, run_config

if TYPE_CHECKING:
    from walker.process import WalkResult

SWITCH_INTERVAL: Final = 5e-4
"""s for which a command being checked may hold up a tick; Python's own 5 ms are half a cycle."""


def walk(
    robot: options.Body = None,
    gait: options.Gait = None,
    velocity: options.Velocity = None,
    target: options.Target = None,
    stabilizer: options.Stabilizer = None,
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
    standby: Annotated[
        bool, typer.Option("--standby", help="With --serve: leave the robot to others until told to take it.")
    ] = False,
    recover: options.Recover = None,
    realtime_priority: options.RealtimePriority = True,
    config: options.Config = None,
) -> Answer:
    """Walk the robot at the other end of the link, emulated or real, as soon as it appears.

    Example: nao-hil walk --gait static --steps 20 --connect tcp/192.168.1.7:7447

    With --serve it waits for `nao-hil drive`, the live page, or your own program (docs/protocol.md).
    Ctrl-C in a walk closes the feet first; a second one leaves the robot at once.
    """
    # imported late: the walk needs SciPy, which help and completion need not wait for
    with loading():
        from nao_hil.runs.build import configuration_warnings, controller_maker
        from walker.process import WalkerProcess
        from walker.service import WalkService

    settings = run_config(
        config,
        robot=robot,
        gait=gait,
        velocity=velocity,
        target=target,
        stabilizer=stabilizer,
        torso=torso,
        admittance=admittance,
        steps=steps,
        duration=duration,
        recover=recover,
    )
    log_to_stderr()
    for warning in configuration_warnings(settings):
        logging.getLogger(__name__).warning("%s", warning)
    body = settings.robot if robot is not None or config is not None else None
    priority = CONTROLLER_PRIORITY if realtime_priority else None
    # made first: a wrong parameter is an error before the link is opened
    if body is not None:
        load_body(body)
    orders = settings.gait, settings.parameters, settings.controller
    service = WalkService(*orders, recover=settings.recover, standby=standby) if serve else None
    make = service.make if service is not None else controller_maker(settings)
    with ControllerLink(name, connect, controller) as link:
        if service is not None:
            link.serve(WALK_COMMAND, service.answer)
            sys.setswitchinterval(SWITCH_INTERVAL)
        stop = stop_event(link.wake)
        process = WalkerProcess(link, make, body, stop.is_set, priority, service)
        error: NaoHilError | None = None
        try:
            process.run()
        except NaoHilError as raised:
            if not process.result().ticks:
                raise
            error = raised
    result = process.result()
    settings = settings if body else msgspec.structs.replace(settings, robot=result.body)
    return _answer(result, settings, serve, error)


ROBOT_SIDE: Final = ("wear", "engine", "scenario", "start", "mode", "seed", "guard")
"""Fields of `RunConfig` that are the robot's; its recording has them."""


def _answer(result: WalkResult, settings: RunConfig, serve: bool, error: NaoHilError | None) -> Answer:
    """Result, configuration and exit code of a walk, and the error that ended it."""
    config = {key: value for key, value in msgspec.to_builtins(settings).items() if key not in ROBOT_SIDE}
    data = msgspec.to_builtins(result) | {"config": config}
    late = LinkError("The link is worse than a walk bears; the robot stands. See docs/network.md.")
    worse = error or (late if result.late and not serve and not result.fell else None)
    if result.failure and not serve and not result.fell:
        worse = worse or WalkFailed(f"The walk ended: {result.failure}. The robot stands.")
    code = 1 if result.fell else 0 if result.done or serve else 130
    return Answer(data, "" if serve else in_words(result), code, worse)


def in_words(result: WalkResult) -> str:
    """The walk in one sentence."""
    if result.fell and not result.steps:
        return "The robot lies and made no step; --recover or `nao-hil motion get-up --connect` gets it up."
    x, y, turn = result.displacement
    stands = result.done or result.state == "stand"
    ending = "fell" if result.fell else "stands" if stands else f"was left in state `{result.state}`"
    return (
        f"The robot {ending} after {result.steps} steps: {x:.3f} m ahead, {y:.3f} m to the left, turned by "
        f"{math.degrees(turn):.1f} deg, by its odometry."
    )
