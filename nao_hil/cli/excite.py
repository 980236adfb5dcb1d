"""`nao-hil excite`: a motion that shows what a robot's drives are like."""

from __future__ import annotations

from typing import Annotated

import msgspec
import typer

from bridge.link import DEFAULT_ROBOT
from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.cli.engine import chosen_engine
from nao_hil.runs.config import run_config
from nao_hil.runs.folder import RunDirectory


def excite(
    duration: Annotated[
        float, typer.Option("--duration", help="Of the motion, s; at least 60.", metavar="S")
    ] = 600.0,
    start: Annotated[
        str,
        typer.Option("--start", help="hang: all joints; stand: head and arms only.", metavar="hang|stand"),
    ] = "hang",
    connect: Annotated[
        str | None,
        typer.Option(
            "--connect",
            help="Zenoh endpoint of the robot; default: an emulated robot in this process.",
            metavar="ENDPOINT",
        ),
    ] = None,
    name: options.Name = DEFAULT_ROBOT,
    robot: options.Body = None,
    wear: options.Wear = None,
    engine: options.Engine = None,
    seed: options.Seed = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    as_json: options.Json = False,
) -> int:
    """Move joint after joint, slowly and in small steps, and record it for `nao-hil identify`.

    A robot that hangs by its shoulders moves all joints, one that stands only head and arms. It takes the
    robot from where it is and brings it back there. --robot, --wear, --engine and --seed are for the emulated
    one.

    Example: nao-hil excite --wear worn --duration 120 --out worn

    Example: nao-hil excite --connect tcp/192.168.1.7:7447 --start hang
    """
    # imported late: physics and the link are for those who use them
    from rich.progress import Progress

    from nao_hil.connection import connect as connected
    from nao_hil.identification.excitation_run import check_start, excite_emulated, excite_linked

    check_start(start, duration)
    console = open_console()
    settings = run_config(None, robot=robot, wear=wear, engine=engine, seed=seed, start=start)
    directory = RunDirectory(out)
    directory.clear(overwrite=overwrite)
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("excitation", total=1.0)

        def show(share: float) -> None:
            bar.update(task, completed=share)

        if connect is None:
            settings = chosen_engine(settings, console)
            directory.write_config(settings)
            result = excite_emulated(settings, duration, directory.recording, show)
        else:
            with connected(connect, robot=name, name="excite") as link:
                result = excite_linked(link, start, duration, directory.recording, show)
    directory.write_summary(msgspec.to_builtins(result))
    console.print(
        f"{result.seconds:.1f} s of {result.robot} in {result.recording}", highlight=False, soft_wrap=True
    )
    if as_json:
        print(msgspec.json.encode(result).decode(), flush=True)
    return 0
