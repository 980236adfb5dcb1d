"""The report of a comparison, with its figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from bridge.body.joints import JOINTS
from nao_hil.analysis.report.render import Picture, Report, ReportPage, ReportTable, write_report
from nao_hil.files import save_figure
from nao_hil.identification.comparison import Comparison, JointComparison, JointFollowing, SensorComparison
from nao_hil.identification.leg_model import ORDERS
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
_HEAD = (
    "joint",
    "difference, deg",
    "floor, deg",
    "excess, deg",
    "tracking error, deg",
    "delay, ms",
    "hysteresis, deg",
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
        tables=tuple(
            table for table in (_joints(result), _sensors(result), _fused(result), _legs(result)) if table.rows
        ),
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


def _joints(result: Comparison) -> ReportTable:
    rows = [
        (
            joint.joint,
            *(f"{math.degrees(value):.3f}" for value in (joint.difference, joint.floor, joint.excess)),
            *_both(joint.recorded, joint.replayed),
        )
        for joint in result.joints
    ]
    return ReportTable("Joints; pairs are recorded / replayed", _HEAD, tuple(rows))


def _both(recorded: JointFollowing, replayed: JointFollowing) -> tuple[str, ...]:
    return tuple(
        " / ".join(_scaled(getattr(each, name), scale, digits) for each in (recorded, replayed))
        for name, scale, digits in (
            ("tracking_error", 180.0 / math.pi, 2),
            ("delay", 1e3, 1),
            ("hysteresis", 180.0 / math.pi, 2),
        )
    )


def _scaled(value: float | None, scale: float, digits: int) -> str:
    return "-" if value is None else f"{scale * value:.{digits}f}"


def _sensors(result: Comparison) -> ReportTable:
    rows = [
        (
            sensor.sensor,
            f"{sensor.recorded_mean:.4g} / {sensor.replayed_mean:.4g}",
            f"{sensor.recorded_rms:.4g} / {sensor.replayed_rms:.4g} / {sensor.floor_rms:.4g}",
        )
        for sensor in result.sensors
    ]
    head = ("sensor", "mean, recorded / replayed", "RMS about it, recorded / replayed / second replay")
    return ReportTable("Gyroscope (rad/s), accelerometer (m/s^2), force cells (N)", head, tuple(rows))


def _fused(result: Comparison) -> ReportTable:
    head = ("angle", "difference RMS, deg", "recorded RMS, deg", "largest step, recorded / emulated, deg")
    rows = []
    if (found := result.fused_angle) is not None:
        columns = (found.difference, found.recorded_rms, found.recorded_step, found.emulated_step)
        for name, values in zip(("roll", "pitch"), zip(*columns, strict=True), strict=True):
            difference, rms, recorded, emulated = (f"{math.degrees(value):.2f}" for value in values)
            rows.append((name, difference, rms, f"{recorded} / {emulated}"))
    title = "Fused angle, and the emulated filter's from the recorded gyroscope and accelerometer"
    return ReportTable(title, head, tuple(rows))


def _legs(result: Comparison) -> ReportTable:
    leg_model = result.leg_model
    joints = () if leg_model is None else ORDERS[leg_model.order]
    rows = []
    for each in () if leg_model is None else leg_model.horizons:
        pairs = (
            (each.overall("recorded"), each.overall("replayed")),
            *((each.recorded[joint], each.replayed[joint]) for joint in joints),
        )
        rows.append(
            (str(each.frames), *(f"{math.degrees(one):.2f} / {math.degrees(two):.2f}" for one, two in pairs))
        )
    title = "Model of the walking legs: RMS error, deg, recorded / replayed"
    return ReportTable(title, ("frames ahead", "all", *joints), tuple(rows))
