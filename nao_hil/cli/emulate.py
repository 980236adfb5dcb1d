"""`nao-hil emulate`: the process of a world and its robots."""

from __future__ import annotations

import threading
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import msgspec
import typer
from rich.console import Console

from bridge.adapters.gamecontroller.referee import Referee, Schedule, load_schedule
from bridge.errors import ConfigurationError
from bridge.guard import Guard
from bridge.host import robot_info
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, RobotLink
from bridge.realtime import ROBOT_PRIORITY, quiet_process
from bridge.recording.recorder import Recorder
from nao_hil import __version__
from nao_hil.cli import options
from nao_hil.cli.added_options import takes_run
from nao_hil.cli.console import Answer, chosen_engine, open_console
from nao_hil.cli.signals import stop_event
from nao_hil.runs.config import RunConfig
from nao_hil.runs.folder import RunDirectory, robot_scene
from nao_hil.runs.summary import RunStatistics, starved
from nao_hil.runs.world_file import Member, members


class _Link(NamedTuple):
    """The options of robots on the link."""

    listen: str
    disarmed: bool
    dry_run: bool
    out: Path | None
    overwrite: bool


@takes_run("robot", "wear", "engine", "scenario", "start", "mode", "seed")
def emulate(
    settings: RunConfig,
    name: options.Name = DEFAULT_ROBOT,
    listen: options.Listen = DEFAULT_ENDPOINT,
    robots: Annotated[
        int,
        typer.Option(
            "--robots", min=1, max=20, help="Like robots in one world, in a row; their ids are ID1, ID2, ..."
        ),
    ] = 1,
    world: Annotated[
        Path | None,
        typer.Option(
            "--world",
            help="File that lists the robots of one world (TOML: name, robot, wear, seed, start, at, yaw, "
            "team, player).",
            metavar="FILE",
            show_default=False,
        ),
    ] = None,
    game: Annotated[
        Path | None,
        typer.Option(
            "--game",
            help="Schedule of a game of the league (TOML): a referee on the world's time calls it.",
            metavar="FILE",
            show_default=False,
        ),
    ] = None,
    realtime_priority: options.RealtimePriority = True,
    disarmed: Annotated[
        bool, typer.Option("--disarmed", help="Start as a real robot does: `nao-hil arm` comes first.")
    ] = False,
    dry_run: options.DryRun = False,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
) -> Answer:
    """Run emulated robots until Ctrl-C; controllers may come and go.

    Example: nao-hil emulate --robot nao-v6 --mode lockstep --seed 7
    """
    if settings.mode == "in-process":
        raise ConfigurationError("mode in-process needs the walker too: `nao-hil up --mode in-process`.")
    console = open_console()
    settings = chosen_engine(settings)
    stop = stop_event()
    link = _Link(listen, disarmed, dry_run, out, overwrite)
    found = members(settings, name, robots, world)
    schedule = None if game is None else load_schedule(game)
    if schedule is not None and not any(member.player for member in found):
        raise ConfigurationError(
            "--game: no robot plays; give robots `team` and `player` in the file of --world."
        )
    return Answer(_run(found, settings, link, schedule, realtime_priority, stop, console))


def _run(
    found: list[Member],
    settings: RunConfig,
    link: _Link,
    schedule: Schedule | None,
    priority: bool,
    stop: threading.Event,
    console: Console,
) -> dict[str, Any]:
    # Imported late: the walker's machine has no PyBullet, and the command line must start there too.
    from emulator.engine.settings import SETTINGS
    from emulator.process import WorldProcess
    from emulator.scenarios import load_scenario
    from emulator.start import build_world
    from emulator.timing import CycleTimer
    from nao_hil.runs.build import build_robot, require_upright

    scenario = load_scenario(settings.scenario)
    world = build_world(settings.engine, SETTINGS, scenario, settings.seed)
    robots = [
        build_robot(config, scenario, name=name, at=at, player=player, world=world)
        for name, config, at, player in found
    ]
    referee = world.referee = None if schedule is None else Referee(schedule, sends=True)
    world.start()
    for robot in robots:
        require_upright(robot)
    statistics = [RunStatistics(config.seed, config.engine) for _, config, *_ in found]
    with ExitStack() as opened:
        if referee is not None:
            opened.callback(referee.close)
        sides, directories = _open(opened, found, robots, statistics, link)
        for directory in directories:
            directory.write_scenario(scenario)
        for name, robot, directory in zip((member.name for member in found), robots, directories, strict=True):
            console.print(
                f"robot `{name}` ({robot.body.title}) at {link.listen}, {settings.mode}; "
                f"recording to {directory.path}"
            )
        process = WorldProcess(sides, stop)
        timer = CycleTimer(robots[0].body.cycle)
        if settings.mode == "real-time":
            quiet_process(ROBOT_PRIORITY if priority else None)
            process.real_time(timer)
        else:
            process.lockstep()
        summaries = {}
        for (name, config, *_), own, side in zip(found, statistics, sides, strict=True):
            summary: dict[str, Any] = msgspec.to_builtins(own.summary(process.wall_seconds))
            if settings.mode == "real-time":
                times = timer.times
                summary["timing"] = msgspec.to_builtins(times)
                summary["starved"] = starved(summary["cycles"], summary["cycles_missed"], times.skipped)
                if summary["starved"]:
                    whose = f"{name}: " if len(found) > 1 else ""
                    console.print(whose + summary["starved"])
            summary["commands_refused"] = side.link.refused
            summaries[name] = summary | {"config": msgspec.to_builtins(config)}
    robots[0].world.engine.close()
    for summary, directory in zip(summaries.values(), directories, strict=True):
        directory.write_summary({key: value for key, value in summary.items() if key != "config"})
    return summaries[found[0].name] if len(found) == 1 else {"robots": summaries}


def _open(
    opened: ExitStack, found: list[Member], robots: list[Any], statistics: list[RunStatistics], link: _Link
) -> tuple[list[Any], list[RunDirectory]]:
    """The sides of the robots on the link, and the folders of their runs.

    Args:
        opened: Closes links and recordings.
        found: The robots as configured.
        robots: The same, emulated.
        statistics: Of each.
        link: Options.
    """
    from emulator.process import RobotSide

    software = f"nao-hil {__version__}"
    links: list[RobotLink] = []
    for (name, config, *_), robot in zip(found, robots, strict=True):
        info = robot_info(robot.body, robot=name, side="emulator", mode=config.mode, software=software)
        first = links[0] if links else None
        links.append(opened.enter_context(RobotLink(info, link.listen, announced=False, beside=first)))
    # the run can begin: the folders keep their content until here
    whole = RunDirectory(link.out)
    directories = [whole] if len(found) == 1 else [RunDirectory(whole.path / name) for name, *_ in found]
    sides = []
    for (_, config, *_), robot, own, side, directory in zip(
        found, robots, statistics, links, directories, strict=True
    ):
        directory.clear(overwrite=link.overwrite)
        recorder = opened.enter_context(Recorder(directory.recording, config, robot_scene(robot.body)))
        directory.write_config(config)
        guard = Guard(robot.body, config.guard, armed=not link.disarmed, dry_run=link.dry_run)
        sides.append(RobotSide(robot, side, guard, [own, recorder], dry_run=link.dry_run))
    return sides, directories
