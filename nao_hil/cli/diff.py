"""`nao-hil diff`: differences of two recorded runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final

import msgspec
import typer

from bridge.errors import ConfigurationError
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console

SAME_TIME: Final = 0.05
"""Robot time within which two events are one, s."""
NOT_COMPARED: Final = ("file", "config", "messages", "diagnosis")


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

    Example: nao-hil diff runs/20260101T120000Z runs/20260101T120500Z
    """
    if len(runs) != 2:
        raise ConfigurationError(f"diff compares two runs, {len(runs)} given; name two.")
    found = differences(*runs)
    return Answer(found, lambda: _print(found), code=1 if any(found.values()) else 0)


def differences(first: Path, second: Path) -> dict[str, Any]:
    """Differences: `config` and `figures` by name with both values, `events` of one run only.

    Raises:
        ConfigurationError: not a recording.
    """
    # imported late: the analysis takes time
    from nao_hil.analysis.diagnosis import symptoms_of
    from nao_hil.analysis.inspection import inspect
    from nao_hil.runs.run import load

    contents = [msgspec.to_builtins(inspect(file)) for file in (first, second)]
    configs = [_flat(one["config"] or {}) for one in contents]
    figures = [{k: v for k, v in one.items() if k not in NOT_COMPARED} for one in contents]
    runs = [load(file) for file in (first, second)]
    events = [[(s.time, s.text) for s in symptoms_of(run.cycles(), run.body)] for run in runs]
    alone = [_alone(events[0], events[1]), _alone(events[1], events[0])]
    return {
        "config": _unequal(*configs),
        "figures": _unequal(*(_flat(figure) for figure in figures)),
        "events": alone if any(alone) else [],
    }


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as one, with dots between the keys."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _unequal(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, list[Any]]:
    names = [*first, *(name for name in second if name not in first)]
    both = {name: [first.get(name), second.get(name)] for name in names}
    return {name: values for name, values in both.items() if values[0] != values[1]}


def _alone(events: list[tuple[float, str]], others: list[tuple[float, str]]) -> list[list[Any]]:
    """Events that the other run does not have at that time."""

    def shared(time: float, text: str) -> bool:
        return any(words == text and abs(when - time) <= SAME_TIME for when, words in others)

    return [[round(time, 3), text] for time, text in events if not shared(time, text)]


def _print(found: dict[str, Any]) -> None:
    from rich.table import Table

    console = open_console(stderr=False)
    if not any(found.values()):
        console.print("The runs are the same.")

    for title in ("config", "figures"):
        if found[title]:
            table = Table("", "first", "second", title=title)
            for name, values in found[title].items():
                table.add_row(name, *(f"{v:.4g}" if isinstance(v, float) else str(v) for v in values))
            console.print(table)
    for name, events in zip(("first", "second"), found["events"], strict=False):
        for time, text in events:
            console.print(f"only in the {name}, at {time:.2f} s: {text}")
