"""The report of a comparison, with its figures."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from bridge.body.joints import JOINTS
from nao_hil.analysis.report.render import (
    Column,
    Columns,
    Picture,
    Report,
    ReportPage,
    ReportTable,
    table,
    write_report,
)
from nao_hil.files import save_figure
from nao_hil.identification.comparison import Comparison, JointComparison, SensorComparison
from nao_hil.identification.leg_model import ORDERS, Horizon, LegModelComparison
from nao_hil.identification.readings import Signals

SHOWN: Final = 4
"""Joints that are drawn over time."""
_STRETCH: Final = 8.0
"""Time that is drawn, s."""
_ABOUT = (
    "The commands of a recording, replayed open loop through the emulated robot. The noise floor of a joint is "
    "the difference of two such replays with different seeds, and at least one step of the encoder; the "
    "excess is the difference beyond it."
)


def plot_ranking(path: Path, joints: Sequence[JointComparison]) -> None:
    """Difference of each joint, and its noise floor."""
    figure = Figure(figsize=(9.0, 0.28 * len(joints) + 1.2), layout="constrained")
    axes = figure.subplots()
    rows = np.arange(len(joints))[::-1]
    axes.barh(rows, np.degrees([joint.difference for joint in joints]), label="recorded less replayed")
    axes.barh(rows, np.degrees([joint.floor for joint in joints]), height=0.4, color="0.3", label="noise floor")
    axes.set_yticks(rows, [joint.joint for joint in joints], fontsize=8)
    axes.set_xlabel("RMS difference of the angle, deg")
    axes.legend()
    axes.grid(axis="x", alpha=0.3)
    save_figure(figure, path)


def plot_joints(path: Path, joints: Sequence[JointComparison], recorded: Signals, replayed: Signals) -> None:
    """The joints that differ most, where they do most: over time, and angle less command over command."""
    figure = Figure(figsize=(11.0, 2.6 * len(joints)), layout="constrained")
    for row, joint in zip(figure.subplots(len(joints), 2, squeeze=False), joints, strict=True):
        number = JOINTS.index(joint.joint)
        rows = _worst(recorded.position[:, number] - replayed.position[:, number], recorded.cycle)
        command = np.degrees(recorded.command[:, number])
        row[0].plot(recorded.time[rows], command[rows], "k--", lw=0.8, label="command")
        for name, signals in (("recorded", recorded), ("replayed", replayed)):
            angle = np.degrees(signals.position[:, number])
            row[0].plot(signals.time[rows], angle[rows], lw=1.0, label=name)
            row[1].plot(command, angle - command, ".", ms=1.5, label=name)
        row[0].set(ylabel=f"{joint.joint}, deg", xlabel="time, s")
        row[1].set(ylabel="angle - command, deg", xlabel="command, deg")
        for axes in row:
            axes.grid(alpha=0.3)
        row[0].legend(fontsize=7)
    save_figure(figure, path)


def plot_spectra(path: Path, sensors: Sequence[SensorComparison]) -> None:
    """Power spectral densities, a panel per axis or cell."""
    columns = 4 if len(sensors) > 6 else 3
    figure = Figure(figsize=(11.0, 2.4 * -(-len(sensors) // columns)), layout="constrained")
    panels: list[Any] = figure.subplots(-(-len(sensors) // columns), columns, squeeze=False).ravel().tolist()
    for axes, sensor in zip(panels, sensors, strict=False):
        for name in ("recorded", "replayed"):
            density = np.maximum(getattr(sensor, f"{name}_density")[1:], 1e-12)
            axes.loglog(sensor.frequency[1:], density, lw=1.0, label=name)
        axes.minorticks_off()  # they take most of the time
        axes.set_title(sensor.sensor, fontsize=9)
        axes.grid(alpha=0.3)
    for axes in panels[len(sensors) :]:
        axes.set_visible(False)
    panels[0].legend(fontsize=7)
    figure.supxlabel("frequency, Hz", fontsize=9)
    save_figure(figure, path)


def _worst(difference: Any, cycle: float) -> slice:
    """The stretch in which the squared difference is largest."""
    length = min(round(_STRETCH / cycle), len(difference))
    sums = np.cumsum(np.append(0.0, np.square(difference)))
    begin = int(np.argmax(sums[length:] - sums[:-length]))
    return slice(begin, begin + length)


def write_comparison(path: Path, result: Comparison, recorded: Signals, replayed: Signals) -> None:
    """Write the page, its JSON and its pictures.

    Args:
        path: Of the HTML file.
        result: The numbers.
        recorded: Signals of the recording.
        replayed: The same of the emulated robot.

    Raises:
        ConfigurationError: jinja2 is not installed.
    """
    config = result.config
    page = ReportPage(
        name="compare",
        title=result.sentence,
        source=result.recording,
        setup=tuple((name, str(value)) for name, value in config.items() if value not in ("", None)),
        claims=(),
        pictures=tuple(_pictures(path.parent, result, recorded, replayed)),
        tables=tuple(each for each in _tables(result) if each.rows),
    )
    robot = f"{config['robot']}, {config['wear']} drives and sensors, on {config['engine']}"
    facts = [
        ("recording", result.recording),
        ("replayed on", robot),
        ("seconds", f"{result.seconds:.2f}"),
        *(("note", note) for note in result.notes),
    ]
    write_report(path, Report("A recording and the emulated robot", [page], facts, about=_ABOUT))


def _pictures(folder: Path, result: Comparison, recorded: Signals, replayed: Signals) -> list[Picture]:
    pictures = []
    if result.joints:
        ranking, joints = folder / "ranking.png", folder / "joints.png"
        plot_ranking(ranking, result.joints)
        plot_joints(joints, result.joints[:SHOWN], recorded, replayed)
        about = "Left: the stretch in which they differ most. Right: all samples, the loop of hysteresis."
        pictures += [
            Picture(ranking, "Difference by joint", "RMS of the angle recorded less that of the replay."),
            Picture(joints, "The joints that differ most", about),
        ]
    for name, title in (("gyroscope", "Gyroscope"), ("accelerometer", "Accelerometer"), ("fsr", "Force cells")):
        sensors = [sensor for sensor in result.sensors if sensor.sensor.startswith(name)]
        if sensors:
            plot_spectra(folder / f"{name}.png", sensors)
            pictures.append(Picture(folder / f"{name}.png", title, "Power spectral density, Welch's method."))
    return pictures


def _scaled(name: str, scale: float, digits: int) -> Column:
    """A cell of both robots."""

    def cell(joint: JointComparison) -> str:
        values = (getattr(each, name) for each in (joint.recorded, joint.replayed))
        return " / ".join("-" if value is None else f"{scale * value:.{digits}f}" for value in values)

    return cell


_DEGREES: Final = 180.0 / math.pi
_JOINTS: Final[Columns] = {
    "joint": "{0.joint}",
    "difference, deg": lambda joint: f"{math.degrees(joint.difference):.3f}",
    "floor, deg": lambda joint: f"{math.degrees(joint.floor):.3f}",
    "excess, deg": lambda joint: f"{math.degrees(joint.excess):.3f}",
    "tracking error, deg": _scaled("tracking_error", _DEGREES, 2),
    "delay, ms": _scaled("delay", 1e3, 1),
    "hysteresis, deg": _scaled("hysteresis", _DEGREES, 2),
}
_SENSORS: Final[Columns] = {
    "sensor": "{0.sensor}",
    "mean, recorded / replayed": "{0.recorded_mean:.4g} / {0.replayed_mean:.4g}",
    "RMS about it, recorded / replayed / second replay": "{0.recorded_rms:.4g} / {0.replayed_rms:.4g} / "
    "{0.floor_rms:.4g}",
}
_FUSED: Final[Columns] = {
    "angle": "{0[0]}",
    "difference RMS, deg": "{0[1]:.2f}",
    "recorded RMS, deg": "{0[2]:.2f}",
    "largest step, recorded / emulated, deg": "{0[3]:.2f} / {0[4]:.2f}",
}


def _tables(result: Comparison) -> list[ReportTable]:
    angles: list[tuple[Any, ...]] = []
    if (found := result.fused_angle) is not None:
        parts = (found.difference, found.recorded_rms, found.recorded_step, found.emulated_step)
        angles = [(name, *np.degrees(values)) for name, *values in zip(("roll", "pitch"), *parts, strict=True)]
    return [
        table("Joints; pairs are recorded / replayed", result.joints, _JOINTS),
        table("Gyroscope (rad/s), accelerometer (m/s^2), force cells (N)", result.sensors, _SENSORS),
        table(
            "Fused angle, and the emulated filter's from the recorded gyroscope and accelerometer",
            angles,
            _FUSED,
        ),
        *([] if result.leg_model is None else [_legs(result.leg_model)]),
    ]


def _legs(found: LegModelComparison) -> ReportTable:
    def cell(each: Horizon, joint: str) -> str:
        pair = (math.degrees(errors[joint]) for errors in (each.recorded, each.replayed))
        return "{:.2f} / {:.2f}".format(*pair)

    def overall(each: Horizon) -> str:
        pair = (math.degrees(each.overall(which)) for which in ("recorded", "replayed"))
        return "{:.2f} / {:.2f}".format(*pair)

    columns: dict[str, Column] = {"frames ahead": "{0.frames}", "all": overall}
    columns |= {joint: functools.partial(cell, joint=joint) for joint in ORDERS[found.order]}
    return table("Model of the walking legs: RMS error, deg, recorded / replayed", found.horizons, columns)
