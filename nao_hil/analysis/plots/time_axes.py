"""Axes over time with phases and events marked."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bridge.types import Array
from nao_hil.analysis.plots.tables import SINGLE, Tables

_SHADE: Final = {"SSL": "tab:blue", "SSR": "tab:red"}
_TIME: Final = "time, s"
_BEFORE_FALL: Final = 0.2
"""Values from this time before a fall on do not widen an axis, s: they would hide the walk."""
_ROOM: Final = 0.05
"""Share of its range that an axis has above and below."""


def time_axes(t: Tables, figure: Figure, labels: tuple[str, ...]) -> list[Axes]:
    """One axis above the other over time, phases and events marked."""
    axes: list[Axes] = list(np.atleast_1d(figure.subplots(len(labels), 1, sharex=True)))
    for ax, label in zip(axes, labels, strict=True):
        ax.set_ylabel(label)
        mark_phases(t, ax)
    axes[-1].set_xlabel(_TIME)
    return axes


def mark_phases(t: Tables, ax: Axes) -> None:
    """Single supports as bands (blue: on the left foot, red: on the right), events and the fall as lines."""
    for phase, begin, end in t.phases():
        if phase in SINGLE:
            ax.axvspan(begin, end, color=_SHADE[phase], alpha=0.07, lw=0.0)
    for when in t.events:
        ax.axvline(when, color="0.2", lw=1.1, ls=":")
    if t.fell is not None:
        ax.axvline(t.fell, color="tab:red", lw=1.5)


def plot_line(ax: Axes, time: Array, values: Array, label: str, **style: Any) -> None:
    """A line over time (s), unless there is nothing; an empty label keeps it out of the legend."""
    if len(time):
        ax.plot(time, values, label=label or None, **style)


def explain_marks(t: Tables, figure: Figure) -> None:
    """A legend of bands and vertical lines, below the axes over time."""
    if not any(ax.get_xlabel() == _TIME for ax in figure.axes):
        return
    phases = {phase for phase, _, _ in t.phases()}
    handles: list[Artist] = [
        Patch(color=_SHADE[phase], alpha=0.2, lw=0.0, label=f"single support on the {side} foot")
        for phase, side in (("SSL", "left"), ("SSR", "right"))
        if phase in phases
    ]
    if t.events:
        handles.append(Line2D([], [], color="0.2", lw=1.1, ls=":", label="event: push, plate, fault, reset"))
    if t.fell is not None:
        handles.append(Line2D([], [], color="tab:red", lw=1.5, label="fall"))
    if handles:
        figure.legend(handles=handles, fontsize=7, ncols=4, loc="outside lower center", frameon=False)


def fit_to_walk(t: Tables, figure: Figure) -> None:
    """Ranges of the axes over time by the values before the fall."""
    if t.fell is None:
        return
    for ax in figure.axes:
        if not any(label.startswith("time") for label in (ax.get_xlabel(), _below(ax))):
            continue
        curves = [line for line in ax.get_lines() if len(np.unique(line.get_xdata())) > 1]
        kept = [
            np.asarray(line.get_ydata(), dtype=np.float64)[
                np.asarray(line.get_xdata(), dtype=np.float64) < t.fell - _BEFORE_FALL
            ]
            for line in curves
        ]
        values = np.concatenate(kept) if kept else np.zeros(0)
        values = values[np.isfinite(values)]
        if len(values) and np.ptp(values) > 0.0:
            room = _ROOM * float(np.ptp(values))
            ax.set_ylim(float(values.min()) - room, float(values.max()) + room)


def _below(ax: Axes) -> str:
    """The x label of the axis that shares its time, at the bottom."""
    return next(
        (other.get_xlabel() for other in ax.get_shared_x_axes().get_siblings(ax) if other.get_xlabel()), ""
    )


def legend_above(ax: Axes) -> None:
    """A legend in one row above the axis."""
    ax.legend(fontsize=7, ncols=6, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
