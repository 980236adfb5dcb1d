"""Draws named plots of a recording into files."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, cast

import numpy as np
from matplotlib.figure import Figure

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from nao_hil.analysis.plots import PLOTS
from nao_hil.analysis.plots.balance_figures import com, margin, path, plane, torso, zmp
from nao_hil.analysis.plots.difference import MARK, draw_difference, over_time
from nao_hil.analysis.plots.motion_figures import (
    admittance,
    cells,
    control,
    current,
    cycle,
    error,
    fsr,
    imu,
    joints,
)
from nao_hil.analysis.plots.time_axes import explain_marks, fit_to_walk
from nao_hil.files import save_figure
from nao_hil.runs.run import Run

FIGURES: Final[dict[str, tuple[Callable[[Run, Figure], None], tuple[float, float], tuple[str, ...]]]] = {
    "torso": (torso, (10.0, 8.0), ("sensors",)),
    "zmp": (zmp, (10.0, 6.0), ("walk/telemetry",)),
    "plane": (plane, (10.0, 5.0), ("walk/telemetry",)),
    "margin": (margin, (10.0, 4.0), ("walk/telemetry",)),
    "com": (com, (10.0, 6.0), ("walk/telemetry",)),
    "fsr": (fsr, (10.0, 5.0), ("sensors",)),
    "cells": (cells, (10.0, 6.0), ("sensors",)),
    "admittance": (admittance, (10.0, 7.0), ("walk/telemetry",)),
    "control": (control, (10.0, 6.0), ("walk/telemetry",)),
    "joints": (joints, (11.0, 9.0), ("sensors",)),
    "error": (error, (11.0, 9.0), ("sensors", "actuators")),
    "current": (current, (10.0, 6.0), ("sensors",)),
    "imu": (imu, (10.0, 6.0), ("sensors",)),
    "path": (path, (10.0, 4.0), ()),
    "cycle": (cycle, (10.0, 5.0), ("sensors",)),
}
"""Name -> how it is drawn, its size in inches, and the topics without which there is nothing to draw."""
DASHED: Final = {"dashed: ": "--", "dotted: ": ":", "dash-dotted: ": "-."}
"""Line styles of the second and later runs."""


def missing(run: Run, name: str) -> list[str]:
    """Topics that a plot needs and of which the run has no message.

    Raises:
        ConfigurationError: unknown name.
    """
    if name not in FIGURES:
        raise ConfigurationError(unknown_name("plot", name, FIGURES))
    return [topic for topic in FIGURES[name][2] if not run[topic].rows]


def draw(runs: Sequence[tuple[Run, str]], name: str, file: Path, differ: Sequence[str] = ()) -> None:
    """Draw one plot; the file's suffix gives the format. Of two runs over time it has their difference too.

    Args:
        runs: Each run with its title; curves of the second and later ones are dashed over the first's.
        name: Of `nao_hil.analysis.plots.PLOTS`.
        file: To write.
        differ: Lines of the title that name what differs.

    Raises:
        ConfigurationError: unknown name, nothing recorded that it could show, or no place to write to.
    """
    for run, title in runs:
        if lacking := missing(run, name):
            nothing = f"nothing of {lacking[0]} was recorded"
            raise ConfigurationError(f"{title}: there is no plot `{name}`: {nothing}.")
    make, (width, height), _ = FIGURES[name]
    shows, first = PLOTS[name], runs[0][0]
    others = [Figure(figsize=(width, height)) for _ in runs[1:]]
    for (other, _), second in zip(runs[1:], others, strict=True):
        make(other, second)
    two = len(runs) == 2 and over_time(others[0])
    whole = Figure(figsize=(1.8 * width if two else width, height), layout="constrained")
    parts = whole.subfigures(1, 2, width_ratios=(5, 4)) if two else (whole, whole)
    figure, panel = (cast(Figure, part) for part in parts)  # all that is drawn takes either
    titles = "\n".join(f"{style}{title}" for style, (_, title) in zip(("", *DASHED), runs, strict=False))
    whole.suptitle("\n".join((f"{shows[0].upper()}{shows[1:]}", titles, *differ)), fontsize=10)
    make(first, figure)
    if two:
        falls = [each.fell for each, _ in runs if each.fell is not None]
        draw_difference(figure, others[0], panel, min(falls, default=math.inf))
    for (other, _), second, dashes in zip(runs[1:], others, DASHED.values(), strict=False):
        fell = math.inf if other.fell is None or not over_time(second) else other.fell
        _overlay(figure, second, dashes, fell)
    fit_to_walk(first, figure)
    explain_marks(first, figure)
    save_figure(whole, file)


def _overlay(figure: Figure, other: Figure, dashes: str, until: float) -> None:
    """Curves of another figure with the same axes to a time, thinner; its marks and legends stay away."""
    for axes, found in zip(figure.axes, other.axes, strict=False):
        for line in found.lines:
            if np.size(line.get_xdata()) > MARK:
                x, y = np.asarray(line.get_data(), dtype=float)
                axes.plot(x[x <= until], y[x <= until], dashes, color=line.get_color(), lw=0.9, alpha=0.85)
