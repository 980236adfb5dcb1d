"""The report of an identification."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from bridge.body.joints import INDEX
from nao_hil.analysis.report.render import Picture, Report, ReportPage, ReportTable, write_report
from nao_hil.analysis.statistics import Estimate
from nao_hil.files import save_figure
from nao_hil.identification.fit import Fit
from nao_hil.identification.identification import Identification
from nao_hil.identification.readings import Signals

_ABOUT: Final = (
    "The emulator's drives, fitted to the joint angles of a recording by robust least squares. The model has "
    "one joint at a time, with the gravity and the inertia that the data sheet gives to its load. "
    "Intervals are from the scatter over stretches of motion, and allow for the model's own error."
)
_COLUMNS: Final = 4


def write_identification(path: Path, result: Identification, found: Fit, signals: Signals) -> None:
    """Write the page, its JSON and its picture.

    Args:
        path: Of the HTML file.
        result: The numbers.
        found: The fit.
        signals: Of the recording.

    Raises:
        ConfigurationError: jinja2 is not installed.
    """
    picture = path.with_suffix(".png")
    _plot(picture, found, signals)
    page = ReportPage(
        name="identify",
        title=f"{len(result.parameters)} values of {result.robot}",
        source=result.recording,
        setup=(("base", result.base), ("profile", result.profile), ("assumed", ", ".join(result.assumed))),
        claims=(),
        pictures=(
            Picture(
                picture,
                "Angle less command over command",
                "The samples that counted; recorded, and by the model with the identified drives.",
            ),
        ),
        tables=(_values(result), _residuals(result)),
    )
    facts = [
        ("recording", result.recording),
        ("seconds", f"{result.seconds:.1f}"),
        ("confidence", f"{result.confidence:.0%}"),
        *(("note", note) for note in result.notes),
    ]
    write_report(path, Report("An identified robot", [page], facts, about=_ABOUT))


def _plot(path: Path, found: Fit, signals: Signals) -> None:
    shown = [i for i in range(len(found.joints)) if found.samples[:, i].any()]
    rows = -(-len(shown) // _COLUMNS)
    figure = Figure(figsize=(13.0, 2.5 * rows), layout="constrained")
    panels: list[Any] = figure.subplots(rows, _COLUMNS, squeeze=False).ravel().tolist()
    for axes, i in zip(panels, shown, strict=False):
        used, column = found.samples[:, i] > 0.0, INDEX[found.joints[i]]
        command = np.degrees(signals.command[used, column])
        for angles, label in (
            (signals.position[used, column], "recorded"),
            (found.predicted[used, i], "model"),
        ):
            axes.plot(command, np.degrees(angles) - command, ".", ms=1.2, alpha=0.6, label=label)
        axes.set_title(found.joints[i], fontsize=9)
        axes.grid(alpha=0.3)
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    panels[0].legend(fontsize=7, markerscale=6)
    figure.supxlabel("command, deg", fontsize=9)
    figure.supylabel("angle - command, deg", fontsize=9)
    save_figure(figure, path)


def _values(result: Identification) -> ReportTable:
    rows = [
        (name, *in_words(name, each), f"{50.0 * (each.interval[1] - each.interval[0]) / each.value:.1f} %")
        for name, each in result.parameters.items()
        if each.value > 0.0
    ]
    return ReportTable("Identified", ("parameter", "value", "interval", "half width"), tuple(rows))


def in_words(name: str, each: Estimate) -> tuple[str, str]:
    """Value and interval of a parameter in the units that people use."""
    kind = name.partition(".")[0]
    scale, unit = {
        "delay": (1e3, "ms"),
        "backlash": (180.0 / math.pi, "deg"),
        "stiffness": (1.0, "N m/rad"),
        "full_voltage_error": (1.0, "rad"),
        "gear_compliance": (1.0, "rad/(N m)"),
        "dry_friction": (1.0, "N m"),
        "lead": (1e3, "ms"),
        "motor_time_constant": (1e3, "ms"),
        "gear_relaxation": (1e3, "ms"),
    }[kind]
    low, high = (scale * bound for bound in each.interval)
    return f"{scale * each.value:.4g} {unit}", f"{low:.4g} to {high:.4g}"


def _residuals(result: Identification) -> ReportTable:
    rows = [
        (joint, f"{math.degrees(value):.3f}") for joint, value in result.residual.items() if value is not None
    ]
    return ReportTable("Residual of the model", ("joint", "RMS, deg"), tuple(rows))
