"""How each named plot is drawn; figures are made without pyplot, so nothing is global."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bridge.datasheet.model import Side
from bridge.datasheet.sole import sole_hull
from bridge.joints import INDEX, JOINTS, LEG_SLOTS
from bridge.messages import WalkTelemetry
from lab.plots.tables import SINGLE, Array, Tables, column, roll_pitch
from walker.support_polygon import SupportPolygon, convex_hull

_SHADE: Final = {"SSL": "tab:blue", "SSR": "tab:red"}
_LEGS: Final = ("HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")
_CELLS: Final = ("front left", "front right", "rear left", "rear right")
_MM: Final = 1e3


def torso(t: Tables, figure: Figure) -> None:
    """Roll and pitch of the torso."""
    axes = _rows(t, figure, ("roll, deg", "pitch, deg"))
    true = np.degrees(roll_pitch(column(t.truth, "torso_orientation", 4)))
    fused = np.degrees(column(t.sensors, "angle", 2))
    own = np.degrees(column(t.telemetry, "angle", 2))
    for i, ax in enumerate(axes):
        _line(ax, t.time, fused[:, i], "fused angle of the robot", lw=0.8)
        _line(ax, t.telemetry_time, own[:, i], "as the walker takes it", lw=0.8)
        _line(ax, t.truth_time, true[:, i], "ground truth", color="black", lw=0.8)
    axes[0].legend(fontsize=8)


def zmp(t: Tables, figure: Figure) -> None:
    """ZMP over time, both coordinates of the walk frame."""
    axes = _rows(t, figure, ("ZMP x, mm", "ZMP y, mm"))
    _against_plan(t, axes, "zmp", t.to_walk_frame(column(t.truth, "zmp", 2)))
    measured = _MM * column(t.telemetry, "zmp_measured", 2)
    for i, ax in enumerate(axes):
        _line(ax, t.telemetry_time, measured[:, i], "from the foot sensors", lw=0.6)
    axes[0].legend(fontsize=8)


def com(t: Tables, figure: Figure) -> None:
    """Centre of mass over time, both coordinates of the walk frame."""
    axes = _rows(t, figure, ("centre of mass x, mm", "centre of mass y, mm"))
    _against_plan(t, axes, "com", t.to_walk_frame(column(t.truth, "com", 3)[:, :2]))
    axes[0].legend(fontsize=8)


def _against_plan(t: Tables, axes: list[Axes], field: str, true: Array) -> None:
    planned = _MM * column(t.telemetry, field, 2)
    for i, ax in enumerate(axes):
        _line(ax, t.truth_time, _MM * true[:, i], "ground truth", color="black", lw=0.6)
        _line(ax, t.telemetry_time, planned[:, i], "planned", lw=1.2)


def plane(t: Tables, figure: Figure) -> None:
    """Footprints, ZMP and centre of mass from above."""
    ax = figure.subplots()
    for side, where in _footprints(t):
        x, y = _MM * (sole_hull(t.body, side) + where).T
        ax.fill(x, y, facecolor="0.9", edgecolor="0.6", lw=0.8)
    true = _MM * t.to_walk_frame(column(t.truth, "com", 3)[:, :2])
    ax.plot(*true.T, lw=0.8, color="black", label="centre of mass, ground truth")
    measured = _MM * column(t.telemetry, "zmp_measured", 2)
    ax.plot(*measured.T, ".", ms=1.0, color="tab:green", label="ZMP from the foot sensors")
    ax.plot(*(_MM * column(t.telemetry, "zmp", 2)).T, lw=1.2, color="tab:orange", label="ZMP planned")
    ax.plot(*(_MM * column(t.telemetry, "com", 2)).T, lw=0.8, color="tab:blue", label="centre of mass planned")
    ax.set(xlabel="x, mm", ylabel="y, mm", aspect="equal")
    ax.legend(fontsize=8)


def _footprints(t: Tables) -> list[tuple[Side, Array]]:
    """Each place where a foot was planned to stand, once."""
    places: dict[tuple[Side, float, float], Array] = {}
    for message in t.telemetry:
        for side, foot in _standing(message):
            places[side, round(foot[0], 4), round(foot[1], 4)] = np.array(foot[:2])
    return [(key[0], place) for key, place in places.items()]


def _standing(message: WalkTelemetry) -> list[tuple[Side, tuple[float, float, float]]]:
    feet: list[tuple[Side, tuple[float, float, float]]] = [("L", message.left), ("R", message.right)]
    bearing = {"SSL": "L", "SSR": "R"}.get(message.phase, "LR")
    return [(side, foot) for side, foot in feet if side in bearing]


def margin(t: Tables, figure: Figure) -> None:
    """Distance of the ZMP to the edge of the planned support polygon, positive inside."""
    ax = _rows(t, figure, ("distance to the edge, mm",))[0]
    polygons = [_polygon(t, message) for message in t.telemetry]
    for label, field, lw in (("planned ZMP", "zmp", 1.2), ("ZMP from the foot sensors", "zmp_measured", 0.6)):
        distances = [
            polygon.margin(point) if (point := getattr(message, field)) is not None else math.nan
            for polygon, message in zip(polygons, t.telemetry, strict=True)
        ]
        _line(ax, t.telemetry_time, _MM * np.array(distances), label, lw=lw)
    ax.axhline(0.0, color="tab:red", lw=0.8)
    ax.legend(fontsize=8)


def _polygon(t: Tables, message: WalkTelemetry) -> SupportPolygon:
    corners = np.concatenate([sole_hull(t.body, side) + foot[:2] for side, foot in _standing(message)])
    return SupportPolygon(convex_hull(corners.tolist()))


def fsr(t: Tables, figure: Figure) -> None:
    """Force sums and contacts."""
    forces, contacts = figure.subplots(2, 1, sharex=True, height_ratios=(4, 1))
    for ax in (forces, contacts):
        _mark(t, ax)
    cells = column(t.sensors, "fsr", 8)
    touch = column(t.telemetry, "contact", 2)
    for i, name in enumerate(("left foot", "right foot")):
        _line(forces, t.time, cells[:, 4 * i : 4 * i + 4].sum(axis=1), name, lw=0.9)
        contacts.fill_between(t.telemetry_time, i, i + 0.8 * touch[:, i], step="post")
    forces.set(ylabel="sum of four sensors, N")
    contacts.set(xlabel="time, s", yticks=[0.4, 1.4], yticklabels=["left", "right"], ylabel="contact")
    forces.legend(fontsize=8)


def cells(t: Tables, figure: Figure) -> None:
    """Every force sensor."""
    values = column(t.sensors, "fsr", 8)
    for i, (ax, foot) in enumerate(zip(_rows(t, figure, ("left foot, N", "right foot, N")), "LR", strict=True)):
        for k, name in enumerate(_CELLS):
            _line(ax, t.time, values[:, 4 * i + k], f"{foot} {name}", lw=0.8)
        _legend_above(ax)


def admittance(t: Tables, figure: Figure) -> None:
    """What admittances and levelling add to the plan."""
    axes = _rows(t, figure, ("lift of the foot, mm", "on AnkleRoll, deg", "on AnklePitch, deg"))
    fields = (("foot_lift", _MM), ("ankle_roll", 180.0 / math.pi), ("ankle_pitch", 180.0 / math.pi))
    for ax, (field, scale) in zip(axes, fields, strict=True):
        _both(t, ax, field, scale)
    axes[0].legend(fontsize=8)


def control(t: Tables, figure: Figure) -> None:
    """Torso control beside what it controls."""
    axes = _rows(t, figure, ("torso's pitch, deg", "on AnklePitch, deg"))
    _line(axes[0], t.telemetry_time, np.degrees(column(t.telemetry, "angle", 2)[:, 1]), "", lw=0.9)
    _both(t, axes[1], "torso_control", 180.0 / math.pi)
    axes[1].legend(fontsize=8)


def _both(t: Tables, ax: Axes, field: str, scale: float) -> None:
    values = scale * column(t.telemetry, field, 2)
    for i, name in enumerate(("left", "right")):
        _line(ax, t.telemetry_time, values[:, i], name, lw=0.9)


def joints(t: Tables, figure: Figure) -> None:
    """Leg joints, asked for and measured."""
    measured = np.degrees(column(t.sensors, "position", len(JOINTS)))
    asked = np.degrees(column(t.actuators, "position", len(JOINTS)))
    asked_time = t.time_of([frame.reply_to for frame in t.actuators])
    for ax, slot in _leg_axes(t, figure, "deg"):
        _line(ax, t.time, measured[:, slot], "measured", lw=0.8)
        _line(ax, asked_time, asked[:, slot], "asked for", lw=0.6, color="black")


def error(t: Tables, figure: Figure) -> None:
    """Leg joints: by how much they miss what was asked for in the same cycle."""
    asked = {frame.reply_to: frame.position for frame in t.actuators}
    pairs = [(f.time, f.position, asked[f.command]) for f in t.sensors if f.command in asked]
    time = np.array([pair[0] for pair in pairs])
    miss = np.degrees([np.subtract(pair[1], pair[2]) for pair in pairs]).reshape(-1, len(JOINTS))
    for ax, slot in _leg_axes(t, figure, "deg"):
        _line(ax, time, miss[:, slot], "measured less asked for", lw=0.8)


def _leg_axes(t: Tables, figure: Figure, unit: str) -> list[tuple[Axes, int]]:
    """An axis for each of five joints of either leg, with its slot."""
    grid = figure.subplots(len(_LEGS), 2, sharex=True)
    for row, joint in zip(grid, _LEGS, strict=True):
        for ax, side in zip(row, "LR", strict=True):
            ax.set_title(f"{side}{joint}", fontsize=8, pad=2)
            ax.set_ylabel(unit, fontsize=8)
            _mark(t, ax)
    for ax in grid[-1]:
        ax.set_xlabel("time, s")
    return [
        (ax, INDEX[f"{side}{joint}"])
        for row, joint in zip(grid, _LEGS, strict=True)
        for ax, side in zip(row, "LR", strict=True)
    ]


def current(t: Tables, figure: Figure) -> None:
    """Currents and temperatures of the legs."""
    axes = _rows(t, figure, ("current, A", "temperature, °C"))
    slots = sorted({slot for slots in LEG_SLOTS.values() for slot in slots})
    for ax, field in zip(axes, ("current", "temperature"), strict=True):
        values = column(t.sensors, field, len(JOINTS))
        for slot in slots:
            _line(ax, t.time, values[:, slot], JOINTS[slot], lw=0.6)
    _legend_above(axes[0])


def imu(t: Tables, figure: Figure) -> None:
    """Accelerometer and gyroscope."""
    axes = _rows(t, figure, ("specific force, m/s²", "angular velocity, rad/s"))
    for ax, field in zip(axes, ("accelerometer", "gyroscope"), strict=True):
        values = column(t.sensors, field, 3)
        for i, name in enumerate("xyz"):
            _line(ax, t.time, values[:, i], name, lw=0.7)
    axes[0].legend(fontsize=8)


def path(t: Tables, figure: Figure) -> None:
    """Way over ground, in the walk frame."""
    ax = figure.subplots()
    feet = 0.5 * (column(t.telemetry, "left", 3) + column(t.telemetry, "right", 3))[:, :2]
    ax.plot(*feet.T, lw=1.0, label="odometry by the plan")
    true = t.to_walk_frame(column(t.truth, "torso_position", 3)[:, :2])
    ax.plot(*true.T, lw=0.8, color="black", label="torso, ground truth")
    ax.set(xlabel="x, m", ylabel="y, m", aspect="equal")
    ax.legend(fontsize=8)


def cycle(t: Tables, figure: Figure) -> None:
    """How old commands are, and how many came too late."""
    axes = _rows(t, figure, ("age of the command, cycles", "cycles missed so far"))
    command = column(t.sensors, "command")
    age = np.where(command >= 0, column(t.sensors, "seq") - command, np.nan)
    _line(axes[0], t.time, age, "", lw=0.7)
    missed = column(t.sensors, "missed")
    _line(axes[1], t.time, missed, "", lw=0.9)
    for ax, values in zip(axes, (age, missed), strict=True):
        ax.set_ylim(0.0, 1.1 * max(3.0, float(np.nanmax(values, initial=0.0))))


FIGURES: Final[dict[str, tuple[Callable[[Tables, Figure], None], tuple[float, float], tuple[str, ...]]]] = {
    "torso": (torso, (10.0, 6.0), ("sensors",)),
    "zmp": (zmp, (10.0, 6.0), ("telemetry",)),
    "plane": (plane, (10.0, 5.0), ("telemetry",)),
    "margin": (margin, (10.0, 4.0), ("telemetry",)),
    "com": (com, (10.0, 6.0), ("telemetry",)),
    "fsr": (fsr, (10.0, 5.0), ("sensors",)),
    "cells": (cells, (10.0, 6.0), ("sensors",)),
    "admittance": (admittance, (10.0, 7.0), ("telemetry",)),
    "control": (control, (10.0, 6.0), ("telemetry",)),
    "joints": (joints, (11.0, 9.0), ("sensors",)),
    "error": (error, (11.0, 9.0), ("sensors", "actuators")),
    "current": (current, (10.0, 6.0), ("sensors",)),
    "imu": (imu, (10.0, 6.0), ("sensors",)),
    "path": (path, (10.0, 4.0), ()),
    "cycle": (cycle, (10.0, 5.0), ("sensors",)),
}
"""Name -> how it is drawn, its size in inches, and the messages without which there is nothing to draw."""


def _rows(t: Tables, figure: Figure, labels: tuple[str, ...]) -> list[Axes]:
    """One axis above the other over time, phases and events marked."""
    axes: list[Axes] = list(np.atleast_1d(figure.subplots(len(labels), 1, sharex=True)))
    for ax, label in zip(axes, labels, strict=True):
        ax.set_ylabel(label)
        _mark(t, ax)
    axes[-1].set_xlabel("time, s")
    return axes


def _mark(t: Tables, ax: Axes) -> None:
    """Single supports as bands (blue: on the left foot, red: on the right), events and the fall as lines."""
    for phase, begin, end in t.phases():
        if phase in SINGLE:
            ax.axvspan(begin, end, color=_SHADE[phase], alpha=0.07, lw=0.0)
    for when, notice in t.notices:
        if notice.level == "info":
            ax.axvline(when, color="0.5", lw=0.7, ls=":")
    if t.fell is not None:
        ax.axvline(t.fell, color="tab:red", lw=1.5)


def _line(ax: Axes, time: Array, values: Array, label: str, **style: Any) -> None:
    if len(time):
        ax.plot(time, values, label=label or None, **style)


def _legend_above(ax: Axes) -> None:
    ax.legend(fontsize=7, ncols=6, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
