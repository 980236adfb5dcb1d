"""The end of a run on the terminal: a table, the diagnosis of a fall, and the JSON of `nao-hil up`."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from nao_hil.runs.folder import RunDirectory


def conclude(
    summary: dict[str, Any],
    directory: RunDirectory,
    console: Console,
    *,
    interrupted: bool,
    as_json: bool,
    target: Sequence[float] = (),
) -> dict[str, Any]:
    """Add the diagnosis, write the summary and show it.

    Args:
        summary: Of the run, with `fell` and `resets`.
        directory: Folder of the run.
        console: Terminal.
        interrupted: The run was ended by a signal.
        as_json: Print the JSON as well.
        target: Place to which it was to walk, m, m, rad, in the frame of its first pose; empty: none.

    Returns:
        The summary with the diagnosis, and a sentence in `starved` if the run did not keep real time.
    """
    recording = directory.last_recording(summary["resets"])
    summary = {"starved": ""} | summary
    summary["diagnosis"] = _diagnosis(directory, summary["resets"]) if summary["fell"] else None
    directory.write_summary(summary)
    _show(summary, recording, console, interrupted, target)
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
    up = " and got up again" if summary["stands"] and summary["recoveries"] else ""
    return f"The robot fell{times}{resets}{up}"


def _show(
    summary: dict[str, Any], recording: Path, console: Console, interrupted: bool, target: Sequence[float]
) -> None:
    stands = "The robot stands" if summary["stands"] else "The robot lies or sits"
    ending = _fell(summary) if summary["fell"] else "Interrupted" if interrupted else stands
    table = Table(title=ending, show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    table.add_row("steps", str(summary["steps"]))
    if summary["fell"] or summary["recoveries"]:
        table.add_row("falls, got up", f"{summary['falls']}, {summary['recoveries']}")
    x, y, turn = summary["displacement"]
    table.add_row("went", f"{x:.3f} m ahead, {y:.3f} m to the left, turned by {math.degrees(turn):.1f} deg")
    if target:
        table.add_row("from its place", f"{math.hypot(target[0] - x, target[1] - y):.3f} m")
    table.add_row("mean speed", f"{summary['speed']:.4f} m/s, start and stop included")
    if any(summary["velocity"]):
        x, y, turn = summary["velocity"]
        table.add_row("mean velocity after 2 s", f"{x:.3f}, {y:.3f} m/s, {turn:.3f} rad/s")
    if summary["torso_max"]:
        table.add_row("largest torso tilt", f"{math.degrees(summary['torso_max']):.2f} deg")
    table.add_row("real-time factor", f"{summary['real_time_factor']:.2f}")
    table.add_row("cycles", f"{summary['cycles']}, {summary['cycles_missed']} missed")
    table.add_row("recording", str(recording))
    console.print(table)
    for sentence in (summary["diagnosis"], summary["starved"]):
        if sentence:
            console.print(sentence, highlight=False)
