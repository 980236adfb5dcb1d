"""The report of an identification."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from bridge.body.joints import INDEX
from nao_hil.analysis.report.render import Columns, Picture, Report, ReportPage, table, write_report
from nao_hil.analysis.statistics import Estimate
from nao_hil.files import save_figure
from nao_hil.identification.fit import KINDS, Fit
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
        tables=(
            table("Identified", ((n, v) for n, v in result.parameters.items() if v.value > 0.0), _VALUES),
            table(
                "Residual of the model",
                ((joint, error) for joint, error in result.residual.items() if error is not None),
                _RESIDUALS,
            ),
        ),
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


def in_words(name: str, each: Estimate) -> tuple[str, str]:
    """Value and interval of a parameter in the units that people use."""
    kind = name.partition(".")[0]
    unit = "N m/rad" if kind == "stiffness" else KINDS[kind].unit
    scale = {"ms": 1e3, "deg": 180.0 / math.pi}.get(unit, 1.0)
    low, high = (scale * bound for bound in each.interval)
    return f"{scale * each.value:.4g} {unit}", f"{low:.4g} to {high:.4g}"


_VALUES: Final[Columns] = {
    "parameter": "{0[0]}",
    "value": lambda item: in_words(*item)[0],
    "interval": lambda item: in_words(*item)[1],
    "half width": lambda item: f"{50.0 * (item[1].interval[1] - item[1].interval[0]) / item[1].value:.1f} %",
}
_RESIDUALS: Final[Columns] = {"joint": "{0[0]}", "RMS, deg": lambda item: f"{math.degrees(item[1]):.3f}"}
