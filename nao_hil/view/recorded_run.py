"""A recorded run as the page shows it: its rows, footprints and events."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.progress import track

from bridge.errors import ConfigurationError
from bridge.messages import TruthFrame
from bridge.messages.world_state import WorldReply
from nao_hil.analysis.diagnosis import BalanceEstimator, Symptom, Symptoms, explain
from nao_hil.runs.run import TIME_TOLERANCE, Cycle, Run
from nao_hil.view.rows import RunRows, events_json

MAX_ROWS: Final = 20_000
"""Rows of a page; of a longer run every second, third, ... one."""


class TruthTrack:
    """Ground truth of a recorded robot by its time, up to its first reset."""

    def __init__(self, run: Run) -> None:
        self.body = run.body
        self._frames = [cycle.truth for cycle in first_run(run.cycles()) if cycle.truth is not None]
        self._times = [frame.time for frame in self._frames]

    def at(self, time: float) -> TruthFrame | None:
        """The newest one of a time, s; None: none so early."""
        found = bisect_right(self._times, time + TIME_TOLERANCE)
        return self._frames[found - 1] if found else None


def recorded_rows(
    run: Run,
    title: str,
    world: WorldReply | None,
    others: Mapping[str, TruthTrack] | None = None,
    **header: Any,
) -> bytes:
    """A run up to its first reset, packed.

    Args:
        run: The run.
        title: Its name.
        world: Its surroundings at the start; None where they are not known.
        others: The other robots of its world, by name.
        header: Added to the header.

    Raises:
        ConfigurationError: a recording without sensor frames, or a damaged one.
    """
    observer = BalanceEstimator(run.body)
    others = others or {}
    bodies = {name: track.body for name, track in others.items()}
    watch, rows = Symptoms(observer), RunRows(run.body, world, bodies)
    symptoms: list[Symptom] = []
    table, prints, objects = [], [], []
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
            table.append(rows.row(balance, others={name: track.at(time) for name, track in others.items()}))
            objects.append(cycle.truth.objects if cycle.truth is not None else ())
    if not table:
        raise ConfigurationError("The recording holds no sensor frame; record a robot that runs.")
    events = events_json(symptoms, explain(symptoms, torso_off=off), stood)
    chosen = slice(None, None, 1 + len(table) // MAX_ROWS)
    return rows.pack(
        np.array(table[chosen]), prints, objects[chosen], title=title, subtitle=run.title, **header, **events
    )


def first_run(cycles: Iterable[Cycle]) -> Iterator[Cycle]:
    """The cycles before the robot restarted: a timeline has one run."""
    last = -1
    for cycle in cycles:
        if cycle.sensors.seq <= last:
            return
        last = cycle.sensors.seq
        yield cycle
