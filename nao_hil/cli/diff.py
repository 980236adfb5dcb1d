"""`nao-hil diff`: differences of two recorded runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console


def diff(
    runs: Annotated[
        list[Path],
        typer.Argument(
            help="Two recordings (.mcap), or folders of runs.",
            metavar="RUN RUN",
            show_default=False,
            callback=options.recordings_of,
        ),
    ],
) -> Answer:
    """Print configurations, figures and events in which two recorded runs differ; ends with 1 if they do.

    A value of the configuration is the one in force: the default that applied where the run sets none.

    Example: nao-hil diff runs/20260101T120000Z runs/20260101T120500Z
    """
    if len(runs) != 2:
        raise ConfigurationError(f"diff compares two runs, {len(runs)} given; name two.")
    from nao_hil.analysis.differences import differences  # imported late: the analysis takes time

    differing = differences(*runs)
    return Answer(differing, lambda: _print(differing), code=1 if any(differing.values()) else 0)


def _print(found: dict[str, Any]) -> None:
    from rich.table import Table

    from nao_hil.analysis.differences import value_text

    console = open_console(stderr=False)
    if not any(found.values()):
        console.print("The runs are the same.")

    for title in ("config", "figures"):
        if found[title]:
            table = Table("", "first", "second", title=title)
            for name, values in found[title].items():
                table.add_row(name, *map(value_text, values))
            console.print(table)
    for name, events in zip(("first", "second"), found["events"], strict=False):
        for time, text in events:
            console.print(f"only in the {name}, at {time:.2f} s: {text}")
