"""The end of a run on the terminal: a table, the diagnosis of a fall, and the JSON of `nao-hil up`."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from nao_hil.runs.folder import RunDirectory


def conclude(
    summary: dict[str, Any], directory: RunDirectory, console: Console, *, interrupted: bool, as_json: bool
) -> dict[str, Any]:
    """Add the diagnosis, write the summary and show it.

    Args:
        summary: Of the run, with `fell` and `resets`.
        directory: Folder of the run.
        console: Terminal.
        interrupted: The run was ended by a signal.
        as_json: Print the JSON as well.

    Returns:
        The summary with the diagnosis.
    """
    recording = directory.last_recording(summary["resets"])
    summary = summary | {"diagnosis": _diagnosis(directory, summary["resets"]) if summary["fell"] else None}
    directory.write_summary(summary)
    _show(summary, recording, console, interrupted)
    if as_json:
        print(json.dumps(summary), flush=True)
    return summary


def _diagnosis(directory: RunDirectory, resets: int) -> str | None:
    """Of the last fall, which may have been before a reset."""
    from nao_hil.analysis.diagnosis import diagnose  # imported late: most runs end well, and need no SciPy here

    for number in range(resets, -1, -1):
        diagnosis = diagnose(directory.last_recording(number))
        if diagnosis is not None:
            return diagnosis.sentence
    return None


def _fell(summary: dict[str, Any]) -> str:
    times = "" if summary["falls"] == 1 else f" {summary['falls']} times"
    resets = f" (over {summary['resets']} resets)" if summary["resets"] else ""
    return f"The robot fell{times}{resets}"


def _show(summary: dict[str, Any], recording: Path, console: Console, interrupted: bool) -> None:
    ending = _fell(summary) if summary["fell"] else "Interrupted" if interrupted else "The robot stands"
    table = Table(title=ending, show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    table.add_row("steps", str(summary["steps"]))
    table.add_row("distance", f"{summary['distance']:.3f} m")
    table.add_row("speed over ground", f"{summary['speed']:.4f} m/s")
    table.add_row("largest torso tilt", f"{math.degrees(summary['torso_max']):.2f} deg")
    table.add_row("real-time factor", f"{summary['real_time_factor']:.2f}")
    table.add_row("cycles", f"{summary['cycles']}, {summary['cycles_missed']} missed")
    table.add_row("recording", str(recording))
    console.print(table)
    if summary["diagnosis"] is not None:
        console.print(summary["diagnosis"], highlight=False)
