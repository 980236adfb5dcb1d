"""The thesis' axes: colours, and phase line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from bridge import rotations
from bridge.types import Array
from nao_hil.runs.run import Table

RED: Final = "tab:red"
BLUE: Final = "tab:blue"
GREEN: Final = "tab:green"
CYAN: Final = "tab:cyan"
TALL: Final = (9.0, 6.0)
"""Size of a picture with two panels, inches."""


def phase_line(axes: Any, track: Table, step: float, colour: str = "k") -> None:
    """The phases of a walk as the thesis draws them: 0 in DSL, one `step` higher in SSL, DSR and SSR each.

    Args:
        axes: To draw on.
        track: Of the walk.
        step: In the units of the axis.
        colour: Of the line.
    """
    levels = {name: i * step for i, name in enumerate(("DSL", "SSL", "DSR", "SSR"))}
    values = [levels.get(phase, np.nan) for phase in track["walk/telemetry.phase"]]
    axes.plot(track["time"], values, color=colour, linewidth=0.8, label="phase: DSL, SSL, DSR, SSR")


def feet(axes: Any, time: Array, left: Array, right: Array) -> None:
    """Ankle in the hip's frame over time: x blue, y green, z red; left solid, right dash-dotted; mm."""
    for i, (name, colour) in enumerate((("x", BLUE), ("y", GREEN), ("z", RED))):
        axes.plot(time, 1e3 * left[:, i], color=colour, label=f"{name}, left")
        axes.plot(time, 1e3 * right[:, i], color=colour, linestyle="-.", label=f"{name}, right")


def finish(axes: Any, x: str, y: str, title: str = "") -> None:
    """Labels, grid, and a legend to the right of the axes."""
    axes.set(xlabel=x, ylabel=y, title=title)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def two_conditions(axes: Any, with_: Table, without: Table, quantity: Callable[[Table], Array]) -> None:
    """A quantity over the time of the walk, as the thesis draws both conditions: blue without, red with."""
    for track, colour, label in ((without, BLUE, "without"), (with_, RED, "with")):
        axes.plot(track["time"], quantity(track), color=colour, linewidth=0.9, label=label)


def pitch_and_roll(figure: Figure, with_: Table, without: Table, phases: bool = False) -> None:
    """True torso pitch and roll of both (figures 4.2, 4.9 and 4.16), rad; phases in steps of 0.05."""
    upper, lower = figure.subplots(2, 1, sharex=True)
    for panel, angle in ((upper, rotations.pitch), (lower, rotations.roll)):

        def of(track: Table, angle: Callable[[Array], Array] = angle) -> Array:
            return angle(track["world/truth.torso_orientation"])

        two_conditions(panel, with_, without, of)
        largest = 1.1 * max(float(np.abs(of(track)).max(initial=0.1)) for track in (with_, without))
        panel.set_ylim(-min(largest, 0.6), min(largest, 0.6))
    if phases:
        phase_line(upper, with_ if with_.rows >= without.rows else without, 0.05)
        upper.plot(
            with_["time"],
            with_["walk/telemetry.torso_control"].sum(axis=1),
            CYAN,
            linewidth=0.7,
            label="control, with",
        )
    finish(upper, "", "torso pitch / rad")
    finish(lower, "t / s", "torso roll / rad")
