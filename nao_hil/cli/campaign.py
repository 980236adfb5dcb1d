"""`nao-hil campaign`, `results` and `map`: walks over many robots and parameters."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import typer
from rich.table import Table

from bridge.errors import ConfigurationError, NaoHilError
from nao_hil.cli import options
from nao_hil.cli.console import Answer, chosen_engine, open_console
from nao_hil.cli.progress import running_campaign
from nao_hil.runs.config import run_config
from nao_hil.runs.folder import RunDirectory

if TYPE_CHECKING:
    from nao_hil.campaigns.comparisons import CellComparison

Quantity = Annotated[
    str,
    typer.Argument(help="A quantity of docs/campaigns.md with its range.", metavar="NAME=LOW:HIGH[:CELLS]"),
]


def campaign(
    file: Annotated[Path, typer.Argument(help="TOML: `seeds`, `duration`, tables `base` and `axes`.")],
    cluster: options.Cluster = "local",
    out: options.Out = None,
) -> Answer:
    """Walk every combination of the axes in a file with every seed, and count who walks on.

    Combinations that differ in one quantity are compared in pairs of walks with the same seed.

    The same command with the same --out continues after a stop. Exit code 130: stopped. A walk
    that fails is named at the end; the others count.

    Example: nao-hil campaign slopes.toml --out runs/slopes --cluster tcp://10.0.0.1:8786
    """
    from nao_hil.analysis.statistics import few_words
    from nao_hil.campaigns.comparisons import comparisons
    from nao_hil.campaigns.file import CampaignCell, load_campaign

    asked = load_campaign(file)
    cells = asked.cells()
    directory = RunDirectory(out)
    directory.write_config(msgspec.to_builtins(asked))
    counts = [CampaignCell(point) for point, _ in cells]
    failure: NaoHilError | None = None
    with running_campaign(file.stem, directory, cluster) as (running, progress):
        progress.expect(len(cells) * asked.seeds)
        try:
            for place, result in running.stream(asked.walks(cells)):
                counts[place % len(cells)].ends[result.seed] = result.end
        except NaoHilError as error:
            if not any(cell.ends for cell in counts):
                raise
            failure = error
    title = f"{file.stem}{few_words(asked.seeds)}"
    data: dict[str, Any] = {
        "name": title,
        "config": msgspec.to_builtins(asked.with_defaults()),
        "interrupted": running.interrupted,
        "error": None if failure is None else str(failure),
        "cells": [cell.summary() for cell in counts],
        "comparisons": msgspec.to_builtins(compared := comparisons(counts)),
    }
    directory.write_summary(data)
    if running.interrupted and failure is None:
        open_console().print(f"Stopped; the same command with --out {directory.path} goes on.")
    tables = [_table(title, data["cells"]), *([_comparison_table(compared)] if compared else [])]
    show = partial(open_console(stderr=False).print, *tables)
    return Answer(data, show, 130 if running.interrupted else 0, failure)


def _table(title: str, cells: list[dict[str, Any]]) -> Table:
    table = Table(*cells[0]["point"], "walk on", "95 % interval", "m/s (median)", title=title)
    for cell in cells:
        low, high = cell["interval"]
        table.add_row(
            *map(str, cell["point"].values()),
            f"{cell['survived']} of {cell['n']}",
            f"{100 * low:.0f} to {100 * high:.0f} %",
            "" if cell["speed"] is None else f"{cell['speed']:.3f}",
        )
    return table


def _comparison_table(compared: Sequence[CellComparison]) -> Table:
    from nao_hil.analysis.statistics import percent

    table = Table(
        *("compared", "at", "pairs", "only it walks on", "only the other", "difference, 95 %", "p", "m/s"),
        title="In pairs, on the same seeds",
        caption=f"Difference of the shares that walk on (Newcombe 1998); p of McNemar's exact test, corrected "
        f"for {len(compared)} comparisons (Holm 1979); m/s: where both walk on.",
    )
    for each in compared:
        pair = each.survived
        table.add_row(
            f"{each.quantity} {each.value} against {each.against}",
            ", ".join(f"{name} {value}" for name, value in each.at.items()),
            *map(str, (pair.n, pair.only_with, pair.only_without)),
            f"{100 * pair.difference:+.0f} ({percent(pair.interval)})",
            f"{each.p_value:.2g}",
            each.speed.words(),
        )
    return table


def results(
    query: Annotated[str, typer.Argument(help="SQL about the view `walks`; docs/results.md has ten of them.")],
    folder: Annotated[Path, typer.Argument(help="Searched with all below it.")] = Path("runs"),
) -> Answer:
    """Ask the walks of all campaigns below a folder, in DuckDB's SQL; each walk is a row.

    Example: nao-hil results "SELECT gait, count(*) n, avg(survived::int) share FROM walks GROUP BY gait"
    """
    from nao_hil.campaigns.results import ask

    if query and Path(query).is_dir():
        raise ConfigurationError(f"{query}: is a folder; the query comes first, then the folder.")
    answer = ask(query, folder)
    rows = [
        {n: float(v) if isinstance(v, Decimal) else v for n, v in zip(answer.columns, row, strict=True)}
        for row in answer.rows
    ]
    table = Table(*answer.columns)
    for row in answer.rows:
        table.add_row(*(f"{value:.6g}" if isinstance(value, float) else str(value) for value in row))
    return Answer({"columns": answer.columns, "rows": rows}, table)


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
) -> Answer:
    """Survival over two quantities, as a heat map; most walks are spent where the verdict changes.

    Example: nao-hil map push=0:8 slope=-8:8 --gait dynamic --out runs/push-slope
    """
    from emulator.scenarios import load_scenario
    from nao_hil.analysis.statistics import few_words
    from nao_hil.campaigns.map import draw, parse_axis, summary, survey
    from nao_hil.runs.walk import Walk

    axes = parse_axis(x), parse_axis(y)
    if axes[0].name == axes[1].name:
        raise ConfigurationError(f"{axes[0].name} is given twice; a map takes two different quantities.")
    console = open_console()
    settings = run_config(config, gait=gait, robot=robot, wear=wear, engine=engine, scenario=scenario)
    settings = chosen_engine(settings)
    world = load_scenario(settings.scenario)
    task = Walk(name="map", config=settings, duration=duration, scenario=world, keep_track=False)
    directory = RunDirectory(out)
    directory.write_config(settings)
    with running_campaign("map", directory, cluster) as (campaign, progress):
        progress.begin("map", grows=True)
        surveyed = survey(campaign, task, *axes, first_seed, seeds)
    title = f"{settings.robot}, {settings.wear}, {settings.gait} gait, {duration:g} s{few_words(seeds)}"
    data = {
        "name": title,
        "config": msgspec.to_builtins(settings),
        "duration": duration,
        "first_seed": first_seed,
        "interrupted": campaign.interrupted,
        **summary(surveyed, *axes),
    }
    directory.write_summary(data)
    if surveyed.tried:
        picture = draw(surveyed, *axes, title, directory.path / "map.png")
        console.print(f"map: {picture}", soft_wrap=True)
    console.print(f"{data['walks']} walks, {100 * data['share']:.0f} % of the full grid's {data['full_grid']}.")
    return Answer(data, code=130 if campaign.interrupted else 0)
