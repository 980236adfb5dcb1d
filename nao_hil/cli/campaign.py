"""`nao-hil campaign`: every combination of some axes, with every seed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer
from rich.table import Table

from bridge.errors import NaoHilError
from nao_hil.cli import options
from nao_hil.cli.campaign_progress import CampaignProgress
from nao_hil.cli.console import open_console
from nao_hil.cli.signals import stop_event
from nao_hil.runs.folder import RunDirectory


def campaign(
    file: Annotated[Path, typer.Argument(help="TOML: `seeds`, `duration`, tables `base` and `axes`.")],
    cluster: options.Cluster = "local",
    out: options.Out = None,
    as_json: options.Json = False,
) -> int:
    """Walk every combination of the axes in a file with every seed, and count who walks on.

    The same command with the same --out goes on where it was stopped. Exit code 130: it was stopped. A walk
    that fails is named at the end; the others count.

    Example: nao-hil campaign slopes.toml --out runs/slopes --cluster tcp://10.0.0.1:8786
    """
    from nao_hil.analysis.statistics import few_words
    from nao_hil.campaigns.file import CampaignCell, load_campaign
    from nao_hil.runs.campaign import Campaign

    asked = load_campaign(file)
    cells = asked.cells()
    directory = RunDirectory(out)
    directory.write_config(msgspec.to_builtins(asked))
    stop = stop_event()
    console = open_console()
    counts = [CampaignCell(point) for point, _ in cells]
    failure: NaoHilError | None = None
    with (
        CampaignProgress(console) as progress,
        Campaign(directory.path / "walks", cluster=cluster, stop=stop, progress=progress) as running,
    ):
        progress.begin(file.stem)
        progress.expect(len(cells) * asked.seeds)
        try:
            for place, result in running.stream(asked.walks(cells)):
                counts[place % len(cells)].add(result.end)
        except NaoHilError as error:
            if not any(cell.n for cell in counts):
                raise
            failure = error
    title = f"{file.stem}{few_words(asked.seeds)}"
    data: dict[str, Any] = {
        "name": title,
        "config": msgspec.to_builtins(asked.with_defaults()),
        "interrupted": stop.is_set(),
        "error": None if failure is None else str(failure),
        "cells": [cell.summary() for cell in counts],
    }
    directory.write_summary(data)
    if as_json:
        print(json.dumps(data), flush=True)
    else:
        open_console(stderr=False).print(_table(title, data["cells"]))
    if failure is not None:
        raise failure
    if stop.is_set():
        console.print(f"Stopped; the same command with --out {directory.path} goes on.", highlight=False)
    return 130 if stop.is_set() else 0


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
