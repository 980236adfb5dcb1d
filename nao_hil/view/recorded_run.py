"""A recorded run as the page shows it: its rows, footprints and events."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np
from rich.console import Console
from rich.progress import track

from bridge.errors import ConfigurationError
from bridge.messages.world_state import WorldReply
from nao_hil.analysis.diagnosis import BalanceEstimator, Symptom, Symptoms, explain
from nao_hil.runs.run import Cycle, Run
from nao_hil.view.rows import RunRows, events_json

MAX_ROWS: Final = 20_000
"""Rows of a page; of a longer run every second, third, ... one."""


def recorded_rows(run: Run, title: str, world: WorldReply | None) -> bytes:
    """A run up to its first reset, packed.

    Args:
        run: The run.
        title: Its name.
        world: Its surroundings at the start; None where they are not known.

    Raises:
        ConfigurationError: a recording without sensor frames, or a damaged one.
    """
    observer = BalanceEstimator(run.body)
    watch, rows = Symptoms(observer), RunRows(run.body, world)
    symptoms: list[Symptom] = []
    table, prints = [], []
    fell, stood, off = math.inf, math.inf, False
    console = Console(stderr=True)
    cycles = first_run(run.cycles())
    for cycle in track(cycles, "reading the recording", console=console, transient=True):
        balance, time = observer.update(cycle), cycle.sensors.time
        found = watch.update(balance)
        if math.isinf(fell) and any(s.kind == "fall" for s in found):
            fell, off = time, watch.torso_off
        elif time > fell + 1.0 and math.isinf(stood) and cycle.walk and cycle.walk.state in ("stand", "walk"):
            stood = time
        # motions of a fallen robot are no symptoms
        symptoms += [s for s in found if s.time <= fell or s.kind in ("world", "order")]
        prints += rows.prints(balance)
        if rows.due(time):
            table.append(rows.row(balance))
    if not table:
        raise ConfigurationError("The recording holds no sensor frame; record a robot that runs.")
    events = events_json(symptoms, explain(symptoms, torso_off=off), stood)
    chosen = np.array(table[:: 1 + len(table) // MAX_ROWS])
    return rows.pack(chosen, prints, title=title, subtitle=run.title, **events)


def first_run(cycles: Iterable[Cycle]) -> Iterator[Cycle]:
    """The cycles before the robot restarted: a timeline has one run."""
    last = -1
    for cycle in cycles:
        if cycle.sensors.seq <= last:
            return
        last = cycle.sensors.seq
        yield cycle
