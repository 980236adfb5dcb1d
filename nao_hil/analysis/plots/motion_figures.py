"""Plots of forces, corrections, joints, currents, inertial unit and timing."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bridge.body.joints import INDEX, JOINTS, LEGS
from nao_hil.analysis.plots.balance_figures import MM
from nao_hil.analysis.plots.time_axes import legend_above, mark_phases, plot_line, time_axes, walk_time
from nao_hil.runs.run import Run

_LEGS: Final = ("HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")
_COLOURS: Final = (*_LEGS, "HipYawPitch")

_CELLS: Final = ("front left", "front right", "rear left", "rear right")


def fsr(run: Run, figure: Figure) -> None:
    """Force sums and contacts."""
    forces, contacts = figure.subplots(2, 1, sharex=True, height_ratios=(4, 1))
    for ax in (forces, contacts):
        mark_phases(run, ax)
    cells = run["sensors"]["fsr"]
    touch = run["walk/telemetry"]["contact"]
    for i, name in enumerate(("left foot", "right foot")):
        plot_line(forces, run["sensors"]["time"], cells[:, 4 * i : 4 * i + 4].sum(axis=1), name, lw=0.9)
        contacts.fill_between(walk_time(run), i, i + 0.8 * touch[:, i], step="post")
    forces.set(ylabel="sum of four sensors, N")
    contacts.set(xlabel="time, s", yticks=[0.4, 1.4], yticklabels=["left", "right"], ylabel="contact")
    forces.legend(fontsize=8)


def cells(run: Run, figure: Figure) -> None:
    """Every force sensor."""
    values = run["sensors"]["fsr"]
    for i, (ax, foot) in enumerate(
        zip(time_axes(run, figure, ("left foot, N", "right foot, N")), "LR", strict=True)
    ):
        for k, name in enumerate(_CELLS):
            plot_line(ax, run["sensors"]["time"], values[:, 4 * i + k], f"{foot} {name}", lw=0.8)
        legend_above(ax)


def admittance(run: Run, figure: Figure) -> None:
    """Offsets of admittances and swing-foot orientation control."""
    axes = time_axes(run, figure, ("lift of the foot, mm", "on AnkleRoll, deg", "on AnklePitch, deg"))
    fields = (("foot_lift", MM), ("ankle_roll", 180.0 / math.pi), ("ankle_pitch", 180.0 / math.pi))
    for ax, (field, scale) in zip(axes, fields, strict=True):
        _both(run, ax, field, scale)
    axes[0].legend(fontsize=8)


def control(run: Run, figure: Figure) -> None:
    """Torso control and the torso's pitch."""
    axes = time_axes(run, figure, ("torso's pitch, deg", "on AnklePitch, deg"))
    plot_line(axes[0], walk_time(run), np.degrees(run["walk/telemetry"]["angle"][:, 1]), "", lw=0.9)
    _both(run, axes[1], "torso_control", 180.0 / math.pi)
    axes[1].legend(fontsize=8)


def _both(run: Run, ax: Axes, field: str, scale: float) -> None:
    values = scale * run["walk/telemetry"][field]
    for i, name in enumerate(("left", "right")):
        plot_line(ax, walk_time(run), values[:, i], name, lw=0.9)


def joints(run: Run, figure: Figure) -> None:
    """Leg joints, asked for and measured."""
    measured = np.degrees(run["sensors"]["position"])
    asked = np.degrees(run["actuators"]["position"])
    asked_time = run["actuators"]["reply_to"] * run.body.cycle
    for ax, slot in _leg_axes(run, figure):
        plot_line(ax, run["sensors"]["time"], measured[:, slot], "measured", lw=0.8)
        plot_line(ax, asked_time, asked[:, slot], "asked for", lw=0.6, color="black")
    if handles := figure.axes[0].get_legend_handles_labels()[0]:
        figure.axes[0].legend(handles=handles, fontsize=7)


def error(run: Run, figure: Figure) -> None:
    """Leg joints: difference from the command of the same cycle."""
    sensors, actuators = run["sensors"], run["actuators"]
    rows = actuators.last("reply_to", sensors["command"])
    known = (rows >= 0) & (actuators["reply_to"][rows] == sensors["command"])
    miss = np.degrees(sensors["position"][known] - actuators["position"][rows[known]])
    time = sensors["time"][known]
    for ax, slot in _leg_axes(run, figure):
        plot_line(ax, time, miss[:, slot], "measured less asked for", lw=0.8)


def _leg_axes(run: Run, figure: Figure) -> list[tuple[Axes, int]]:
    """An axis for each of five joints of either leg, with its slot."""
    grid = figure.subplots(len(_LEGS), 2, sharex=True)
    for row, joint in zip(grid, _LEGS, strict=True):
        for ax, side in zip(row, "LR", strict=True):
            ax.set_title(f"{side}{joint}", fontsize=8, pad=2)
            ax.set_ylabel("deg", fontsize=8)
            mark_phases(run, ax)
    for ax in grid[-1]:
        ax.set_xlabel("time, s")
    return [
        (ax, INDEX[f"{side}{joint}"])
        for row, joint in zip(grid, _LEGS, strict=True)
        for ax, side in zip(row, "LR", strict=True)
    ]


def current(run: Run, figure: Figure) -> None:
    """Currents and temperatures of the legs."""
    axes = time_axes(run, figure, ("current, A", "temperature, °C"))
    for ax, field in zip(axes, ("current", "temperature"), strict=True):
        values = run["sensors"][field]
        for slot in LEGS:
            name = JOINTS[slot]
            style = {"color": f"C{_COLOURS.index(name[1:])}", "ls": "-" if name[0] == "L" else "--"}
            plot_line(ax, run["sensors"]["time"], values[:, slot], name, lw=0.6, **style)
    legend_above(axes[0])


def imu(run: Run, figure: Figure) -> None:
    """Accelerometer and gyroscope."""
    axes = time_axes(run, figure, ("specific force, m/s²", "angular velocity, rad/s"))
    for ax, field in zip(axes, ("accelerometer", "gyroscope"), strict=True):
        values = run["sensors"][field]
        for i, name in enumerate("xyz"):
            plot_line(ax, run["sensors"]["time"], values[:, i], name, lw=0.7)
    axes[0].legend(fontsize=8)


def cycle(run: Run, figure: Figure) -> None:
    """Age of the commands, and number of late ones."""
    axes = time_axes(run, figure, ("age of command, cycles", "missed so far, cycles"))
    command = run["sensors"]["command"]
    age = np.where(command >= 0, run["sensors"]["seq"] - command, np.nan)
    plot_line(axes[0], run["sensors"]["time"], age, "", lw=0.7)
    missed = run["sensors"]["missed"]
    plot_line(axes[1], run["sensors"]["time"], missed, "", lw=0.9)
    for ax, values in zip(axes, (age, missed), strict=True):
        ax.set_ylim(0.0, 1.1 * max(3.0, float(np.nanmax(values, initial=0.0))))
