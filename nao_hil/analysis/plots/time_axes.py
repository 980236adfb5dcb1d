"""Axes over time with phases and events marked."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_hil.analysis.plots.tables import SINGLE, Array, Tables

_SHADE: Final = {"SSL": "tab:blue", "SSR": "tab:red"}


def time_axes(t: Tables, figure: Figure, labels: tuple[str, ...]) -> list[Axes]:
    """One axis above the other over time, phases and events marked."""
    axes: list[Axes] = list(np.atleast_1d(figure.subplots(len(labels), 1, sharex=True)))
    for ax, label in zip(axes, labels, strict=True):
        ax.set_ylabel(label)
        mark_phases(t, ax)
    axes[-1].set_xlabel("time, s")
    return axes


def mark_phases(t: Tables, ax: Axes) -> None:
    """Single supports as bands (blue: on the left foot, red: on the right), events and the fall as lines."""
    for phase, begin, end in t.phases():
        if phase in SINGLE:
            ax.axvspan(begin, end, color=_SHADE[phase], alpha=0.07, lw=0.0)
    for when, notice in t.notices:
        if notice.level == "info":
            ax.axvline(when, color="0.5", lw=0.7, ls=":")
    if t.fell is not None:
        ax.axvline(t.fell, color="tab:red", lw=1.5)


def plot_line(ax: Axes, time: Array, values: Array, label: str, **style: Any) -> None:
    """A line over time (s), unless there is nothing; an empty label keeps it out of the legend."""
    if len(time):
        ax.plot(time, values, label=label or None, **style)


def legend_above(ax: Axes) -> None:
    """A legend in one row above the axis."""
    ax.legend(fontsize=7, ncols=6, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
