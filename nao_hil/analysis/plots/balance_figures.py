"""Plots of balance: torso, ZMP, centre of mass, footprints, margin, path."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bridge.body.sole import sole_hull
from bridge.polygon import SupportPolygon, convex_hull
from bridge.rotations import R_yaw, pitch, roll, yaw
from bridge.types import Array, Side
from nao_hil.analysis.plots.time_axes import plot_line, time_axes, walk_time
from nao_hil.runs.run import Run

MM: Final = 1e3
DOWN: Final = 1e-4
"""Planned height below which a sole is on the ground, m."""


def torso(run: Run, figure: Figure) -> None:
    """Roll, pitch and heading of the torso; whole turns count."""
    axes = time_axes(run, figure, ("roll, deg", "pitch, deg", "heading, deg"))
    sensors, walk, truth = run["sensors"], run["walk/telemetry"], run["world/truth"]
    attitude = truth["torso_orientation"]
    true = np.column_stack([roll(attitude), pitch(attitude), yaw(attitude)])
    own = np.column_stack([walk["angle"], walk["place"][:, 2]])
    for i, ax in enumerate(axes):
        if i < 2:
            fused = _degrees(sensors["angle"][:, i])
            plot_line(ax, sensors["time"], fused, "fused angle of the robot", color="tab:blue", lw=0.8)
        walker = _degrees(own[:, i])
        plot_line(ax, walk_time(run), walker, "as the walker takes it", color="tab:orange", lw=0.8)
        plot_line(ax, truth["time"], _degrees(true[:, i]), "ground truth", color="black", lw=0.8)
    axes[0].legend(fontsize=8)


def _degrees(angles: Array) -> Array:
    return np.asarray(np.degrees(np.unwrap(angles)))


def zmp(run: Run, figure: Figure) -> None:
    """ZMP over time, both coordinates of the walk frame."""
    axes = time_axes(run, figure, ("ZMP x, mm", "ZMP y, mm"))
    _against_plan(run, axes, "zmp")
    measured = MM * run["walk/telemetry"]["zmp_measured"]
    for i, ax in enumerate(axes):
        plot_line(ax, walk_time(run), measured[:, i], "from the foot sensors", lw=0.6)
    axes[0].legend(fontsize=8)


def com(run: Run, figure: Figure) -> None:
    """Centre of mass over time, both coordinates of the walk frame."""
    axes = time_axes(run, figure, ("centre of mass x, mm", "centre of mass y, mm"))
    _against_plan(run, axes, "com")
    axes[0].legend(fontsize=8)


def _against_plan(run: Run, axes: list[Axes], column: str) -> None:
    planned = MM * run["walk/telemetry"][column]
    true = MM * to_walk_frame(run, run["world/truth"][column][:, :2])
    for i, ax in enumerate(axes):
        plot_line(ax, run["world/truth"]["time"], true[:, i], "ground truth", color="black", lw=0.6)
        plot_line(ax, walk_time(run), planned[:, i], "planned", lw=1.2)


def to_walk_frame(run: Run, points: Array) -> Array:
    """World x and y to the walk frame, shape (n, 2), m.

    At the walker's first word the planned centre of mass is taken for the true one, the torso's heading
    for the walk's.
    """
    walk, truth = run["walk/telemetry"], run["world/truth"]
    if not (walk.rows and truth.rows):
        return points
    first = min(int(np.searchsorted(truth["seq"], walk["seq"][0])), truth.rows - 1)
    R = R_yaw(float(yaw(truth["torso_orientation"][first])))[:2, :2]
    origin = truth["com"][first, :2] - R @ walk["com"][0]
    return np.asarray((points - origin) @ R, dtype=np.float64)


def _before_fall(run: Run) -> Run:
    """The run up to the cycle before its first fall."""
    return run if run.fell is None else run.between(-math.inf, run.fell - 0.5 * run.body.cycle)


def plane(run: Run, figure: Figure) -> None:
    """Footprints, ZMP and centre of mass from above."""
    run = _before_fall(run)
    ax, walk = figure.subplots(), run["walk/telemetry"]
    for corners in _footprints(run):
        x, y = MM * corners.T
        ax.fill(x, y, facecolor="0.9", edgecolor="0.6", lw=0.8)
    true = MM * to_walk_frame(run, run["world/truth"]["com"][:, :2])
    ax.plot(*true.T, lw=0.8, color="black", label="centre of mass, ground truth")
    measured = MM * walk["zmp_measured"]
    ax.plot(*measured.T, ".", ms=1.0, color="tab:green", label="ZMP from the foot sensors")
    ax.plot(*(MM * walk["zmp"]).T, lw=1.2, color="tab:orange", label="ZMP planned")
    ax.plot(*(MM * walk["com"]).T, lw=0.8, color="tab:blue", label="centre of mass planned")
    ax.set(xlabel="x, mm", ylabel="y, mm", aspect="equal")
    ax.legend(fontsize=8)


def _footprints(run: Run) -> list[Array]:
    """Corners of each planned stance sole, once for each place, shape (n, 2), m."""
    places: dict[tuple[Side, tuple[float, ...]], Array] = {}
    for standing in _standing(run):
        for side, foot in standing:
            places[side, tuple(np.round(foot, 4))] = foot
    return [_sole(run, side, foot) for (side, _), foot in places.items()]


def _sole(run: Run, side: Side, foot: Array) -> Array:
    """Corners of a sole in the walk frame, shape (n, 2), m."""
    corners: Array = sole_hull(run.body, side) @ R_yaw(foot[5])[:2, :2].T + foot[:2]
    return corners


def _standing(run: Run) -> list[list[tuple[Side, Array]]]:
    """Planned stance soles of each cycle."""
    walk = run["walk/telemetry"]
    both: list[list[tuple[Side, Array]]] = [
        [("L", left), ("R", right)] for left, right in zip(walk["left"], walk["right"], strict=True)
    ]
    return [[(side, foot) for side, foot in feet if foot[2] < DOWN] or feet for feet in both]


def margin(run: Run, figure: Figure) -> None:
    """Distance of the ZMP to the edge of the planned support polygon, positive inside."""
    ax = time_axes(run, figure, ("distance to the edge, mm",))[0]
    soles = [np.concatenate([_sole(run, side, foot) for side, foot in feet]) for feet in _standing(run)]
    polygons = [SupportPolygon(convex_hull(corners.tolist())) for corners in soles]
    for label, column, lw in (("planned ZMP", "zmp", 1.2), ("ZMP from the foot sensors", "zmp_measured", 0.6)):
        points = run["walk/telemetry"][column].tolist()
        distances = [
            math.nan if math.isnan(x) else polygon.margin((x, y))
            for polygon, (x, y) in zip(polygons, points, strict=True)
        ]
        plot_line(ax, walk_time(run), MM * np.array(distances), label, lw=lw)
    ax.axhline(0.0, color="tab:red", lw=0.8)
    ax.legend(fontsize=8)


def path(run: Run, figure: Figure) -> None:
    """Way over ground, in the walk frame."""
    run, ax = _before_fall(run), figure.subplots()
    feet = 0.5 * (run["walk/telemetry"]["left"] + run["walk/telemetry"]["right"])[:, :2]
    ax.plot(*feet.T, lw=1.0, label="odometry by the plan")
    true = to_walk_frame(run, run["world/truth"]["torso_position"][:, :2])
    ax.plot(*true.T, lw=0.8, color="black", label="torso, ground truth")
    ax.set(xlabel="x, m", ylabel="y, m", aspect="equal")
    ax.legend(fontsize=8)
