"""Force with which the swing foot lands on the plate, in numbers and as figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from nao_hil.experiments import axes
from nao_hil.runs.track import Array, Track
from nao_hil.runs.walk import WalkOutcome


@dataclass(frozen=True)
class ObstacleSetup:
    """The experiment's numbers."""

    duration: float = 45.0
    """s; the thesis' robot steps off the plate at about 32 s."""
    plate_time: float = 17.0
    """s of the walk: in SSL, the swing foot on its way down."""
    height: float = 0.01
    """m"""
    force_ratio: float = 0.5
    """Largest force with over that without, at most."""


class Force(msgspec.Struct, frozen=True, kw_only=True):
    """Largest sum of the swing foot's sensors from the plate to the end of that SSL, N: over the runs."""

    median: float
    largest: float


def landing_force(result: WalkOutcome, plate_time: float) -> float | None:
    """Largest sum of the right foot's four sensors from the plate to the end of that SSL, N.

    Until the fall if that is sooner, and until the torso leans 20 degrees: what a falling robot puts on the
    foot is no landing. None: the walk did not come so far.
    """
    track = result.track.until(result.end.time)
    time = track["time"]
    after = np.flatnonzero((time >= plate_time) & track.during("SSL"))
    if not after.size:
        return None
    breaks = np.flatnonzero(np.diff(after) > 1)
    rows = after[: int(breaks[0]) + 1] if breaks.size else after
    rows = rows[track.tilt[rows] < math.radians(20.0)]
    return float(track["fsr"][rows, 4:].sum(axis=1).max()) if rows.size else None


def landing_forces(results: Sequence[WalkOutcome], setup: ObstacleSetup) -> Force:
    """Median and largest landing force over the runs."""
    found = [f for r in results if (f := landing_force(r, setup.plate_time)) is not None]
    if not found:
        return Force(median=math.nan, largest=math.nan)
    return Force(median=float(np.median(found)), largest=max(found))


def plot_force(path: Path, with_: Track, without: Track, plate_time: float) -> Path:
    """Sensors of the swing foot over the time of the walk, N."""
    figure = axes.new_figure(9.0, 7.0)
    longer = with_ if len(with_) >= len(without) else without
    whole, landing = figure.subplots(2, 1)
    for panel in (whole, landing):
        axes.phase_line(panel, longer, 5.0, axes.GREEN)
        axes.two_arms(panel, with_, without, lambda track: track["fsr"][:, 4:].sum(axis=1))
        axes.finish(panel, "t / s", "F_R,Foot,z / N")
    landing.axvline(plate_time, color="k", linestyle=":", linewidth=0.9)
    landing.set(xlim=(plate_time - 1.5, plate_time + 2.5), title="about the plate")
    return axes.save(figure, path)


def plot_feet(path: Path, track: Track, left: Array, right: Array) -> Path:
    """Heights of both soles over the time of the walk, m."""
    figure = axes.new_figure()
    panel = figure.subplots()
    axes.feet(panel, track["time"], left, right)
    axes.phase_line(panel, track, 30.0)
    axes.finish(panel, "t / s", "p_i,0^i,8 / mm")
    return axes.save(figure, path)
