"""Plots of balance: torso, ZMP, centre of mass, footprints, margin, path."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bridge.body.sole import sole_hull
from bridge.messages import WalkTelemetry
from bridge.polygon import SupportPolygon, convex_hull
from bridge.rotations import R_yaw, pitch, roll
from bridge.types import Array, Pose, Side
from nao_hil.analysis.plots.tables import Tables, column
from nao_hil.analysis.plots.time_axes import plot_line, time_axes

MM: Final = 1e3
DOWN: Final = 1e-4
"""Planned height below which a sole is on the ground, m."""


def torso(t: Tables, figure: Figure) -> None:
    """Roll and pitch of the torso."""
    axes = time_axes(t, figure, ("roll, deg", "pitch, deg"))
    orientation = column(t.truth, "torso_orientation", 4)
    true = np.degrees(np.column_stack([roll(orientation), pitch(orientation)]))
    fused = np.degrees(column(t.sensors, "angle", 2))
    own = np.degrees(column(t.telemetry, "angle", 2))
    for i, ax in enumerate(axes):
        plot_line(ax, t.time, fused[:, i], "fused angle of the robot", lw=0.8)
        plot_line(ax, t.telemetry_time, own[:, i], "as the walker takes it", lw=0.8)
        plot_line(ax, t.truth_time, true[:, i], "ground truth", color="black", lw=0.8)
    axes[0].legend(fontsize=8)


def zmp(t: Tables, figure: Figure) -> None:
    """ZMP over time, both coordinates of the walk frame."""
    axes = time_axes(t, figure, ("ZMP x, mm", "ZMP y, mm"))
    _against_plan(t, axes, "zmp", t.to_walk_frame(column(t.truth, "zmp", 2)))
    measured = MM * column(t.telemetry, "zmp_measured", 2)
    for i, ax in enumerate(axes):
        plot_line(ax, t.telemetry_time, measured[:, i], "from the foot sensors", lw=0.6)
    axes[0].legend(fontsize=8)


def com(t: Tables, figure: Figure) -> None:
    """Centre of mass over time, both coordinates of the walk frame."""
    axes = time_axes(t, figure, ("centre of mass x, mm", "centre of mass y, mm"))
    _against_plan(t, axes, "com", t.to_walk_frame(column(t.truth, "com", 3)[:, :2]))
    axes[0].legend(fontsize=8)


def _against_plan(t: Tables, axes: list[Axes], field: str, true: Array) -> None:
    planned = MM * column(t.telemetry, field, 2)
    for i, ax in enumerate(axes):
        plot_line(ax, t.truth_time, MM * true[:, i], "ground truth", color="black", lw=0.6)
        plot_line(ax, t.telemetry_time, planned[:, i], "planned", lw=1.2)


def plane(t: Tables, figure: Figure) -> None:
    """Footprints, ZMP and centre of mass from above."""
    ax = figure.subplots()
    for corners in _footprints(t):
        x, y = MM * corners.T
        ax.fill(x, y, facecolor="0.9", edgecolor="0.6", lw=0.8)
    true = MM * t.to_walk_frame(column(t.before_fall, "com", 3)[:, :2])
    ax.plot(*true.T, lw=0.8, color="black", label="centre of mass, ground truth")
    measured = MM * column(t.telemetry, "zmp_measured", 2)
    ax.plot(*measured.T, ".", ms=1.0, color="tab:green", label="ZMP from the foot sensors")
    ax.plot(*(MM * column(t.telemetry, "zmp", 2)).T, lw=1.2, color="tab:orange", label="ZMP planned")
    ax.plot(*(MM * column(t.telemetry, "com", 2)).T, lw=0.8, color="tab:blue", label="centre of mass planned")
    ax.set(xlabel="x, mm", ylabel="y, mm", aspect="equal")
    ax.legend(fontsize=8)


def _footprints(t: Tables) -> list[Array]:
    """Corners of each planned stance sole, once for each place, shape (n, 2), m."""
    places: dict[tuple[Side, tuple[float, ...]], Pose] = {}
    for message in t.telemetry:
        for side, foot in _standing(message):
            places[side, tuple(round(number, 4) for number in foot)] = foot
    return [_sole(t, side, foot) for (side, _), foot in places.items()]


def _sole(t: Tables, side: Side, foot: Pose) -> Array:
    """Corners of a sole in the walk frame, shape (n, 2), m."""
    corners: Array = sole_hull(t.body, side) @ R_yaw(foot[5])[:2, :2].T + foot[:2]
    return corners


def _standing(message: WalkTelemetry) -> list[tuple[Side, Pose]]:
    feet: list[tuple[Side, Pose]] = [("L", message.left), ("R", message.right)]
    return [(side, foot) for side, foot in feet if foot[2] < DOWN] or feet


def margin(t: Tables, figure: Figure) -> None:
    """Distance of the ZMP to the edge of the planned support polygon, positive inside."""
    ax = time_axes(t, figure, ("distance to the edge, mm",))[0]
    polygons = [_polygon(t, message) for message in t.telemetry]
    for label, field, lw in (("planned ZMP", "zmp", 1.2), ("ZMP from the foot sensors", "zmp_measured", 0.6)):
        distances = [
            polygon.margin(point) if (point := getattr(message, field)) is not None else math.nan
            for polygon, message in zip(polygons, t.telemetry, strict=True)
        ]
        plot_line(ax, t.telemetry_time, MM * np.array(distances), label, lw=lw)
    ax.axhline(0.0, color="tab:red", lw=0.8)
    ax.legend(fontsize=8)


def _polygon(t: Tables, message: WalkTelemetry) -> SupportPolygon:
    corners = np.concatenate([_sole(t, side, foot) for side, foot in _standing(message)])
    return SupportPolygon(convex_hull(corners.tolist()))


def path(t: Tables, figure: Figure) -> None:
    """Way over ground, in the walk frame."""
    ax = figure.subplots()
    feet = 0.5 * (column(t.telemetry, "left", 6) + column(t.telemetry, "right", 6))[:, :2]
    ax.plot(*feet.T, lw=1.0, label="odometry by the plan")
    true = t.to_walk_frame(column(t.before_fall, "torso_position", 3)[:, :2])
    ax.plot(*true.T, lw=0.8, color="black", label="torso, ground truth")
    ax.set(xlabel="x, m", ylabel="y, m", aspect="equal")
    ax.legend(fontsize=8)
