"""`nao-hil map`: who walks on, over two quantities, as a picture."""

from __future__ import annotations

import json
from typing import Annotated

import msgspec
import typer

from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.campaign_progress import CampaignProgress
from nao_hil.cli.console import open_console
from nao_hil.cli.engine import chosen_engine
from nao_hil.cli.signals import stop_event
from nao_hil.runs.config import run_config
from nao_hil.runs.folder import RunDirectory

Quantity = Annotated[
    str,
    typer.Argument(help="A quantity of docs/campaigns.md with its range.", metavar="NAME=LOW:HIGH[:CELLS]"),
]


def map_(
    x: Quantity,
    y: Quantity,
    gait: options.Gait = None,
    robot: options.Body = None,
    wear: options.Wear = None,
    engine: options.Engine = None,
    scenario: options.Scenario = None,
    config: options.Config = None,
    seeds: Annotated[int, typer.Option("--seeds", help="Most walks of a cell.", min=4, metavar="N")] = 20,
    first_seed: Annotated[int, typer.Option("--first-seed", help="The first seed.", min=0, metavar="N")] = 0,
    duration: Annotated[float, typer.Option("--duration", help="Of a walk, s.", min=0.1, metavar="S")] = 10.0,
    cluster: options.Cluster = "local",
    out: options.Out = None,
    as_json: options.Json = False,
) -> int:
    """Survival over two quantities, as a heat map; most walks are spent where the verdict changes.

    Example: nao-hil map push=0:8 slope=-8:8 --gait dynamic --out runs/push-slope
    """
    from emulator.scenarios import load_scenario
    from nao_hil.analysis.statistics import few_words
    from nao_hil.campaigns.map import draw, parse_axis, summary, survey
    from nao_hil.runs.campaign import Campaign
    from nao_hil.runs.walk import Walk

    axes = parse_axis(x), parse_axis(y)
    if axes[0].name == axes[1].name:
        raise ConfigurationError(f"{axes[0].name} is given twice; a map takes two different quantities.")
    console = open_console()
    settings = run_config(config, gait=gait, robot=robot, wear=wear, engine=engine, scenario=scenario)
    settings = chosen_engine(settings, console)
    world = load_scenario(settings.scenario)
    task = Walk(name="map", config=settings, duration=duration, scenario=world, keep_track=False)
    directory = RunDirectory(out)
    directory.write_config(settings)
    stop = stop_event()
    with (
        CampaignProgress(console) as progress,
        Campaign(directory.path / "walks", cluster=cluster, stop=stop, progress=progress) as campaign,
    ):
        progress.begin("map")
        found = survey(campaign, task, *axes, first_seed, seeds)
    title = f"{settings.robot}, {settings.wear}, {settings.gait} gait, {duration:g} s{few_words(seeds)}"
    data = {
        "name": title,
        "config": msgspec.to_builtins(settings),
        "duration": duration,
        "first_seed": first_seed,
        "interrupted": stop.is_set(),
        **summary(found, *axes),
    }
    directory.write_summary(data)
    if found.tried:
        picture = draw(found, *axes, title, directory.path / "map.png")
        console.print(f"map: {picture}", highlight=False, soft_wrap=True)
    console.print(
        f"{data['walks']} walks, {100 * data['share']:.0f} % of the full grid's {data['full_grid']}.",
        highlight=False,
    )
    if as_json:
        print(json.dumps(data), flush=True)
    return 130 if stop.is_set() else 0
