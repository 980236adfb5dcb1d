"""`nao-hil emulate`: the robot's process."""

from __future__ import annotations

import threading
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer
from rich.console import Console

from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.guard import Guard
from bridge.host import robot_info
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, RobotLink
from bridge.realtime import ROBOT_PRIORITY, quiet_process
from bridge.recording.observer import Observer
from bridge.recording.recorder import Recorder
from nao_hil import __version__
from nao_hil.cli import options
from nao_hil.cli.added_options import takes_run
from nao_hil.cli.console import Answer, chosen_engine, open_console
from nao_hil.cli.signals import stop_event
from nao_hil.runs.config import RunConfig
from nao_hil.runs.folder import RunDirectory, robot_scene
from nao_hil.runs.summary import RunStatistics, starved


@takes_run("robot", "wear", "engine", "scenario", "start", "mode", "seed")
def emulate(
    settings: RunConfig,
    name: options.Name = DEFAULT_ROBOT,
    listen: options.Listen = DEFAULT_ENDPOINT,
    realtime_priority: options.RealtimePriority = True,
    disarmed: Annotated[
        bool, typer.Option("--disarmed", help="Start as a real robot does: `nao-hil arm` comes first.")
    ] = False,
    dry_run: options.DryRun = False,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
) -> Answer:
    """Run the emulated robot until Ctrl-C; a controller may come and go.

    Example: nao-hil emulate --robot nao-v6 --mode lockstep --seed 7
    """
    # Imported late: the walker's machine has no PyBullet, and the command line must start there too.
    from nao_hil.runs.build import check_robot

    if settings.mode == "in-process":
        raise ConfigurationError("mode in-process needs the walker too: `nao-hil up --mode in-process`.")
    console = open_console()
    settings = chosen_engine(settings, console)
    stop = stop_event()
    body = check_robot(settings)
    guard = Guard(body, settings.guard, armed=not disarmed, dry_run=dry_run)
    summary = _run(settings, body, guard, name, listen, realtime_priority, out, overwrite, stop, console)
    return Answer(summary | {"config": msgspec.to_builtins(settings)})


def _run(
    settings: RunConfig,
    body: Body,
    guard: Guard,
    name: str,
    listen: str,
    priority: bool,
    out: Path | None,
    overwrite: bool,
    stop: threading.Event,
    console: Console,
) -> dict[str, Any]:
    # Imported late: the walker's machine has no PyBullet, and the command line must start there too.
    from emulator.process import RobotProcess
    from emulator.scenarios import load_scenario
    from emulator.timing import CycleTimer
    from nao_hil.runs.build import build_robot, require_upright

    software = f"nao-hil {__version__}"
    info = robot_info(body, robot=name, side="emulator", mode=settings.mode, software=software)
    statistics = RunStatistics(settings.seed, settings.engine)
    scenario = load_scenario(settings.scenario)
    robot = build_robot(settings, scenario)
    require_upright(robot)
    with ExitStack() as opened:
        link = opened.enter_context(RobotLink(info, listen, announced=False))
        directory = RunDirectory(out)  # the run can begin: the folder keeps its content until here
        directory.clear(overwrite=overwrite)
        recorder = opened.enter_context(Recorder(directory.recording, settings, robot_scene(body)))
        directory.write_config(settings)
        directory.write_scenario(scenario)
        observers: list[Observer] = [statistics, recorder]
        process = RobotProcess(robot, link, guard, observers, stop, dry_run=guard.status.dry_run)
        console.print(
            f"robot `{name}` ({body.title}) at {listen}, {settings.mode}; recording to {directory.path}"
        )
        summary: dict[str, Any]
        if settings.mode == "real-time":
            timer = CycleTimer(body.cycle)
            quiet_process(ROBOT_PRIORITY if priority else None)
            process.real_time(timer)
            summary = msgspec.to_builtins(statistics.summary(process.wall_seconds))
            times = timer.times
            summary["timing"] = msgspec.to_builtins(times)
            summary["starved"] = starved(summary["cycles"], summary["cycles_missed"], times.skipped)
            if summary["starved"]:
                console.print(summary["starved"], highlight=False)
        else:
            process.lockstep()
            summary = msgspec.to_builtins(statistics.summary(process.wall_seconds))
        summary["commands_refused"] = link.refused
    robot.close()
    directory.write_summary(summary)
    return summary
