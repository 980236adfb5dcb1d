"""`nao-hil info`: what is in a recording."""

from __future__ import annotations

import math
from typing import Any

import msgspec
from rich.table import Table

from nao_hil.cli import options
from nao_hil.cli.console import open_console


def info(file: options.Recording, as_json: options.Json = False) -> int:
    """Tell what is in a recording: robot, run, times, messages, how it went and what went wrong first.

    Also of a recording that was cut off.

    Example: nao-hil info runs/20260101T120000Z/frames.mcap
    """
    from nao_hil.analysis.inspection import inspect

    with open_console().status(f"reading {file}"):
        contents = inspect(file)
    if as_json:
        print(msgspec.json.encode(contents).decode(), flush=True)
        return 0
    table = Table(title=str(file), show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    for name, value in _rows(contents):
        table.add_row(name, value)
    open_console(stderr=False).print(table)
    return 0


def _rows(c: Any) -> list[tuple[str, str]]:
    config = dict(c.config) if isinstance(c.config, dict) else {}
    if not c.messages["walk/telemetry"]:
        config.pop("gait", None)  # the run's setting, but somebody else's controller moved the robot
    rows = [(key, str(config[key])) for key in _NAMED if config.get(key) not in (None, "", {})]
    ending = "whole" if c.complete else "cut off: reads up to its last whole chunk"
    if c.after:
        ending = f"whole, but followed by {c.after} bytes that are not read, as of a second file joined to it"
    rows += [
        ("file", ending),
        ("robot time", f"{c.begin:.2f} to {c.end:.2f} s"),
        ("cycles", f"{c.cycles}, {c.gaps} not recorded, {c.cycles_missed} missed by the controller"),
        ("messages", ", ".join(f"{topic} {n}" for topic, n in c.messages.items() if n) or "none"),
        ("notices", ", ".join(f"{code} {n}" for code, n in c.notices.items()) or "none"),
        (
            "steps",
            str(c.steps) if c.messages["walk/telemetry"] else "not told: the controller sends no telemetry",
        ),
        ("largest torso tilt", f"{math.degrees(c.torso_max):.2f} deg"),
    ]
    if c.fell is not None:
        rows += [("distance", f"{c.distance:.3f} m"), ("fell", "yes" if c.fell else "no")]
    if c.diagnosis is not None:
        rows.append(("what went wrong", c.diagnosis))
    return [*rows, ("sha256 of the frames", c.frames_sha256)]


_NAMED = ("robot", "wear", "scenario", "gait", "mode", "seed", "name", "side", "software")
"""Keys of a run's configuration that are shown."""
