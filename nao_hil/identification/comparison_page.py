"""The report of a comparison."""

from __future__ import annotations

import math
from pathlib import Path

from nao_hil.analysis.report.page import Picture, ReportPage, ReportTable
from nao_hil.analysis.report.render import Report, write_report
from nao_hil.identification.comparison import Comparison, JointFollowing
from nao_hil.identification.comparison_figures import SHOWN, plot_joints, plot_ranking, plot_spectra
from nao_hil.identification.signals import Signals

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
        tables=tuple(table for table in (_joints(result), _sensors(result), _fused(result)) if table.rows),
    )
    robot = f"{config['robot']}, {config['wear']} drives and sensors, on {config['engine']}"
    facts = [
        ("recording", result.recording),
        ("replayed on", robot),
        ("seconds", f"{result.seconds:.2f}"),
        *(("note", note) for note in result.notes),
    ]
    write_report(path, Report("A recording beside the emulated robot", [page], facts, about=_ABOUT))


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
