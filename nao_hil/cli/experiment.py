"""`nao-hil experiment`: measurements of the robot and its walk, with a verdict and a report."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from nao_hil.cli import options
from nao_hil.cli.console import Answer, chosen_engine, open_console
from nao_hil.cli.progress import running_campaign
from nao_hil.experiments.catalogue import ALL, EXPERIMENTS
from nao_hil.runs.config import run_config
from nao_hil.runs.folder import RunDirectory

Seeds = Annotated[
    int | None,
    typer.Option(
        "--seeds",
        help="Runs per condition, each with its own seed; default: the experiment's own.",
        min=1,
        metavar="N",
    ),
]
FirstSeed = Annotated[
    int, typer.Option("--first-seed", help="The first seed; others follow it.", min=0, metavar="N")
]
Duration = Annotated[
    float | None,
    typer.Option(
        "--duration",
        help="Seconds of one run, for `velocity`, `terrain`, `falls` (a push a minute).",
        min=10.0,
        metavar="S",
    ),
]
Wear = Annotated[
    str | None,
    typer.Option(
        "--wear",
        help="Drives and sensors: ideal, nominal (default), worn, ensemble:K (`ensemble`: a robot of it "
        "for each seed), or a profile's path.",
        metavar="WEAR",
    ),
]
Config = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="TOML file; its `robot`, `wear`, `engine`, `gait` and that gait's tables count.",
        metavar="FILE",
    ),
]


def experiment(
    name: Annotated[
        str,
        typer.Argument(
            help="A name of `nao-hil experiments`, or `all`: the thesis' nine.",
            autocompletion=lambda incomplete: [n for n in (*EXPERIMENTS, ALL) if n.startswith(incomplete)],
        ),
    ],
    seeds: Seeds = None,
    first_seed: FirstSeed = 0,
    robot: options.Body = None,
    wear: Wear = None,
    engine: options.Engine = None,
    gait: options.Gait = None,
    config: Config = None,
    cluster: options.Cluster = "local",
    duration: Duration = None,
    out: options.Out = None,
) -> Answer:
    """Run an experiment over many seeds; figures, JSON and report.html go to the run's folder.

    Walks are kept there too: the same command with the same --out continues after a stop. Exit code 1:
    the verdict failed.

    Example: nao-hil experiment obstacle --seeds 6 --first-seed 100 --json
    """
    if name != ALL and name not in EXPERIMENTS:
        raise ConfigurationError(unknown_name("experiment", name, (*EXPERIMENTS, ALL)))
    if duration is not None and not math.isfinite(duration):
        raise ConfigurationError("--duration must be a finite number of seconds.")
    first = None
    if gait is not None:
        if name == ALL or not EXPERIMENTS[name].any_gait:
            takes = ", ".join(f"`{each}`" for each, entry in EXPERIMENTS.items() if entry.any_gait)
            raise ConfigurationError(f"--gait: {name} has gaits of its own; {takes} take one.")
        # refuses an unknown name before anything has begun; the path of a sheet becomes absolute
        several = gait.split(",") if EXPERIMENTS[name].gaits else [gait]
        found = [run_config(None, gait=each).gait for each in several]
        gait, first = ",".join(found), found[0]
    changes = chosen_engine(run_config(config, robot=robot, wear=wear, engine=engine, gait=first))
    directory = RunDirectory(out)
    directory.write_config(changes)
    # Imported late: physics, figures and the template are for those who run one.
    from nao_hil.experiments.context import Context
    from nao_hil.experiments.runner import Runner

    console = open_console()
    names = [n for n, entry in EXPERIMENTS.items() if entry.thesis] if name == ALL else [name]
    with running_campaign(names[0], directory, cluster) as (campaign, progress):
        context = Context(campaign, directory.path, (), changes, duration, gait)
        runner = Runner(context, console, seeds, first_seed)
        for each in names:
            progress.begin(each, grows=True)
            runner.run(each, directory.path / each if name == ALL else directory.path)
    data = runner.summary(name)
    directory.write_summary(data)
    report = runner.report("The thesis' experiments" if name == ALL else f"Experiment {name}")
    if runner.interrupted:
        console.print("Interrupted: the report has what is there.")
    console.print(f"report: {report}", soft_wrap=True)
    return Answer(data, code=130 if runner.interrupted else int(not runner.passed))


def experiments() -> Answer:
    """List the experiments there are."""
    listed = {name: entry.question for name, entry in EXPERIMENTS.items()}
    lines = (listed | {ALL: "those of the thesis, in one report"}).items()
    return Answer(listed, "\n".join(f"{name:14} {what}" for name, what in lines))
