"""Axes over time with phases, events and falls marked."""

from __future__ import annotations

import itertools
from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bridge.messages import Notice
from bridge.types import Array
from nao_hil.runs.run import Run

SINGLE: Final = ("SSL", "SSR")
"""Phases of single support."""
_SHADE: Final = {"SSL": "tab:blue", "SSR": "tab:red"}
_TIME: Final = "time, s"
_BEFORE_FALL: Final = 0.2
"""Values from this time before a fall on do not widen an axis, s: they would hide the walk."""
_AFTER_FALL: Final = 0.5
"""Time that is drawn of a robot that lies to the end, s."""
_ROOM: Final = 0.05
"""Share of its range that an axis has above and below."""


def walk_time(run: Run) -> Array:
    """Times of the walker's telemetry, s, shape (n,)."""
    return np.asarray(run["walk/telemetry"]["seq"] * run.body.cycle, dtype=np.float64)


def phases(run: Run) -> list[tuple[str, float, float]]:
    """Phase of the plan, its begin and its end, s."""
    told = zip(run["walk/telemetry"]["phase"], walk_time(run), strict=True)
    spans = []
    for phase, rows in itertools.groupby(told, key=lambda row: str(row[0])):
        times = [float(time) for _, time in rows]
        spans.append((phase, times[0], times[-1] + run.body.cycle))
    return spans


def events(run: Run) -> list[float]:
    """Times of events in the robot and its world, s."""
    told = run["notices"]
    return [
        float(when)
        for when, level, code in zip(told["time"], told["level"], told["code"], strict=True)
        if level == "info" and not Notice(seq=0, level=str(level), code=str(code), text="").routine
    ]


def falls(run: Run) -> list[tuple[float, float]]:
    """From when to when the robot lies, s, by the ground truth."""
    truth = run["world/truth"]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], truth["fell"].astype(int), [0]])))
    ends = np.append(truth["time"], np.inf)
    return [(float(ends[a]), float(ends[b])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def time_axes(run: Run, figure: Figure, labels: tuple[str, ...]) -> list[Axes]:
    """One axis above the other over time, phases and events marked."""
    axes: list[Axes] = list(np.atleast_1d(figure.subplots(len(labels), 1, sharex=True)))
    for ax, label in zip(axes, labels, strict=True):
        ax.set_ylabel(label)
        mark_phases(run, ax)
    axes[-1].set_xlabel(_TIME)
    return axes


def mark_phases(run: Run, ax: Axes) -> None:
    """Single supports as bands (blue: on the left foot, red: on the right), events and falls as lines."""
    for phase, begin, end in phases(run):
        if phase in SINGLE:
            ax.axvspan(begin, end, color=_SHADE[phase], alpha=0.07, lw=0.0)
    for when in events(run):
        ax.axvline(when, color="0.2", lw=1.1, ls=":")
    for fell, _ in falls(run):
        ax.axvline(fell, color="tab:red", lw=1.5)


def plot_line(ax: Axes, time: Array, values: Array, label: str, **style: Any) -> None:
    """A line over time (s), unless there is nothing; an empty label keeps it out of the legend."""
    if len(time):
        ax.plot(time, values, label=label or None, **style)


def explain_marks(run: Run, figure: Figure) -> None:
    """A legend of bands and vertical lines, below the axes over time."""
    if not any(ax.get_xlabel() == _TIME for ax in figure.axes):
        return
    seen = {phase for phase, _, _ in phases(run)}
    handles: list[Artist] = [
        Patch(color=_SHADE[phase], alpha=0.2, lw=0.0, label=f"single support on the {side} foot")
        for phase, side in (("SSL", "left"), ("SSR", "right"))
        if phase in seen
    ]
    if events(run):
        handles.append(Line2D([], [], color="0.2", lw=1.1, ls=":", label="event: push, plate, fault, reset"))
    if falls(run):
        handles.append(Line2D([], [], color="tab:red", lw=1.5, label="fall"))
    if handles:
        figure.legend(handles=handles, fontsize=7, ncols=4, loc="outside lower center", frameon=False)


def fit_to_walk(run: Run, figure: Figure) -> None:
    """Ranges of the axes over time by the values of a robot on its feet; they end soon after a last fall."""
    down = falls(run)
    if not down:
        return
    for ax in figure.axes:
        if not any(label.startswith("time") for label in (ax.get_xlabel(), _below(ax))):
            continue
        kept = [np.zeros(0)]
        for line in ax.get_lines():
            time, values = (np.asarray(data, dtype=np.float64) for data in line.get_data())
            if len(np.unique(time)) > 1:
                lies = [(time >= fell - _BEFORE_FALL) & (time <= up) for fell, up in down]
                kept.append(values[~np.any(lies, axis=0) & np.isfinite(values)])
        values = np.concatenate(kept)
        if len(values) and np.ptp(values) > 0.0:
            room = _ROOM * float(np.ptp(values))
            ax.set_ylim(float(values.min()) - room, float(values.max()) + room)
        if down[-1][0] > 0.0 and down[-1][1] == np.inf:
            ax.set_xlim(right=min(down[-1][0] + _AFTER_FALL, ax.get_xlim()[1]))


def _below(ax: Axes) -> str:
    """The x label of the axis that shares its time, at the bottom."""
    return next(
        (other.get_xlabel() for other in ax.get_shared_x_axes().get_siblings(ax) if other.get_xlabel()), ""
    )


def legend_above(ax: Axes) -> None:
    """A legend in one row above the axis."""
    ax.legend(fontsize=7, ncols=6, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
