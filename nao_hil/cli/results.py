"""`nao-hil results`: questions in SQL to the walks that were kept."""

from __future__ import annotations

import json
import math
from decimal import Decimal
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.console import open_console


def results(
    query: Annotated[str, typer.Argument(help="SQL about the view `walks`; docs/results.md has ten of them.")],
    folder: Annotated[Path, typer.Argument(help="Searched with all below it.")] = Path("runs"),
    as_json: options.Json = False,
) -> int:
    """Ask the walks of all campaigns below a folder, in DuckDB's SQL; each walk is a row.

    Example: nao-hil results "SELECT gait, count(*) n, avg(survived::int) share FROM walks GROUP BY gait"
    """
    from nao_hil.campaigns.results import ask

    if query and Path(query).is_dir():
        raise ConfigurationError(f"{query}: is a folder; the query comes first, then the folder.")
    answer = ask(query, folder)
    if as_json:
        rows = [
            {name: _in_json(value) for name, value in zip(answer.columns, row, strict=True)}
            for row in answer.rows
        ]
        print(json.dumps({"columns": answer.columns, "rows": rows}, default=str), flush=True)
        return 0
    table = Table(*answer.columns)
    for row in answer.rows:
        table.add_row(*(f"{value:.6g}" if isinstance(value, float) else str(value) for value in row))
    open_console(stderr=False).print(table)
    return 0


def _in_json(value: object) -> object:
    """A value as JSON has it, which has no decimals, no NaN and no infinity."""
    number = float(value) if isinstance(value, Decimal) else value
    return None if isinstance(number, float) and not math.isfinite(number) else number
