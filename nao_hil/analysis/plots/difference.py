"""Curves of one figure less those of another with the same axes, on their common time."""

from __future__ import annotations

from collections import Counter
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bridge.types import Array

MARK: Final = 2
"""Points of a line that marks a time."""


def over_time(figure: Figure) -> bool:
    """Whether the axes of a figure are over time."""
    return any(ax.get_xlabel().startswith("time") for ax in figure.axes)


def draw_difference(first: Figure, second: Figure, panel: Figure, end: float) -> None:
    """Draw the second figure's curves less the first's, in a panel with the axes of the first.

    Args:
        first: Curves over time.
        second: The same of another run.
        panel: Empty.
        end: Time at which the curves end, s: from a fall on they have no meaning.
    """
    panel.suptitle("second less first", fontsize=9)
    kept = [
        (ax, pairs) for ax, other in zip(first.axes, second.axes, strict=False) if (pairs := _pairs(ax, other))
    ]
    columns = len({round(ax.get_position().x0, 3) for ax, _ in kept}) or 1
    grid = panel.subplots(-(-len(kept) // columns) or 1, columns, sharex=True, squeeze=False)
    for ax in grid[-1]:
        ax.set_xlabel("time, s")
    for ax, (mine, pairs) in zip(grid.flat, kept, strict=False):
        ax.axhline(0.0, color="0.6", lw=0.6)
        ax.set(ylabel=mine.get_ylabel(), xlim=mine.get_xlim())
        ax.set_title(mine.get_title(), fontsize=8, pad=2)
        for line, theirs in pairs:
            ax.plot(*_less(line, theirs, end), color=line.get_color(), lw=0.9)


def _pairs(ax: Axes, other: Axes) -> list[tuple[Line2D, Line2D]]:
    """Curves that both axes have."""
    others = _curves(other)
    return [(line, others[name]) for name, line in _curves(ax).items() if name in others]


def _curves(ax: Axes) -> dict[tuple[str, int], Line2D]:
    """Curves by label and number; lines that mark a time or a level are none."""
    lines: dict[tuple[str, int], Line2D] = {}
    seen: Counter[str] = Counter()
    for line in ax.lines:
        if np.size(line.get_xdata()) > MARK:
            label = str(line.get_label())
            label = "" if label.startswith("_") else label
            lines[label, seen[label]] = line
            seen[label] += 1
    return lines


def _less(line: Line2D, other: Line2D, end: float) -> tuple[Array, Array]:
    """Times of a curve that the other has too, and there the other's values less its own."""
    time, values = (np.asarray(data, dtype=np.float64) for data in line.get_data())
    when, theirs = (np.asarray(data, dtype=np.float64) for data in other.get_data())
    common = (time >= when[0]) & (time <= min(when[-1], end))
    return time[common], np.interp(time[common], when, theirs) - values[common]
