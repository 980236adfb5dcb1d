"""Draws named plots of a recording into files."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from nao_hil.analysis.plots.figures import FIGURES
from nao_hil.analysis.plots.names import PLOTS
from nao_hil.analysis.plots.tables import Tables
from nao_hil.analysis.plots.time_axes import explain_marks, fit_to_walk
from nao_hil.files import atomic_path


def missing(tables: Tables, name: str) -> list[str]:
    """Kinds of messages that a plot needs and the recording does not have.

    Raises:
        ConfigurationError: unknown name.
    """
    if name not in FIGURES:
        raise ConfigurationError(unknown_name("plot", name, FIGURES))
    return [kind for kind in FIGURES[name][2] if not getattr(tables, kind)]


def draw(tables: Tables, name: str, file: Path, title: str) -> None:
    """Draw one plot; the file's suffix says in which format.

    Args:
        tables: what was recorded.
        name: of `nao_hil.analysis.plots.names.PLOTS`.
        file: to write.
        title: of the run, above it.

    Raises:
        ConfigurationError: unknown name, nothing recorded that it could show, or no place to write to.
    """
    if lacking := missing(tables, name):
        raise ConfigurationError(f"{title}: there is no plot `{name}`: nothing of {lacking[0]} was recorded.")
    make, size, _ = FIGURES[name]
    figure = Figure(figsize=size, layout="constrained")
    shows = PLOTS[name]
    figure.suptitle(f"{shows[0].upper()}{shows[1:]}\n{title}", fontsize=10)
    make(tables, figure)
    fit_to_walk(tables, figure)
    explain_marks(tables, figure)
    with atomic_path(file) as temporary:
        figure.savefig(temporary, dpi=110)
