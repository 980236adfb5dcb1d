"""`nao-hil compare`: a recorded robot beside the emulated one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer

from nao_hil.cli import options
from nao_hil.cli.console import open_console
from nao_hil.cli.engine import chosen_engine
from nao_hil.runs.config import run_config
from nao_hil.runs.folder import RunDirectory, recording_of

RecordingOrCsv = Annotated[
    Path,
    typer.Argument(
        help="Recording (.mcap or .csv), or the folder of a run.",
        metavar="RECORDING",
        show_default=False,
        callback=recording_of,
    ),
]


def compare(
    recording: RecordingOrCsv,
    robot: options.Body = None,
    wear: options.Wear = None,
    engine: options.Engine = None,
    scenario: options.Scenario = None,
    start: options.Start = None,
    seed: options.Seed = None,
    begin: options.Begin = 0.0,
    end: options.End = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    as_json: options.Json = False,
) -> int:
    """Replay a recording's commands through the emulated robot, and report what differs.

    Body, world and start are those that the recording names, unless options say otherwise; drives and sensors
    are `nominal`. The folder gets report.html and summary.json.

    Example: nao-hil compare frames.mcap --wear worn

    Example: nao-hil compare real.csv --robot nao-v5 --start hang --from 2 --to 60
    """
    # imported late: physics and figures are for those who compare
    from rich.progress import Progress

    from nao_hil.identification.comparison_page import write_comparison
    from nao_hil.identification.comparison_run import compare_recording
    from nao_hil.identification.recorded import read_signals

    options.check_stretch(begin, end)
    console = open_console()
    recorded = read_signals(recording, robot, begin, end)
    named: dict[str, Any] = {
        name: given if given is not None else recorded.config.get(name)
        for name, given in (("robot", robot), ("scenario", scenario), ("start", start))
    }
    settings = chosen_engine(run_config(None, **named, wear=wear, engine=engine, seed=seed), console)
    directory = RunDirectory(out)
    directory.clear(overwrite=overwrite)
    directory.write_config(settings)
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("replay", total=1.0)
        result, replayed = compare_recording(
            recorded, str(recording), settings, lambda share: bar.update(task, completed=share)
        )
    directory.write_summary(msgspec.to_builtins(result))
    page = directory.path / "report.html"
    write_comparison(page, result, recorded.signals, replayed)
    console.print(f"{result.sentence}\nreport: {page}", highlight=False, soft_wrap=True)
    if as_json:
        print(msgspec.json.encode(result).decode(), flush=True)
    return 0
