"""`nao-hil plot`: the named plots of a recording."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from nao_hil.analysis.plots import PLOTS
from nao_hil.cli import options
from nao_hil.cli.console import Answer, open_console
from nao_hil.runs.folder import run_name

if TYPE_CHECKING:
    from nao_hil.analysis.differences import Event
    from nao_hil.runs.run import Run

NAMED: Final = 3
"""Runs that the name of a picture holds."""


def plot(
    files: options.Recordings,
    what: Annotated[
        str,
        typer.Option(
            "--what",
            help="Names, with commas between, or `all`. "
            + "; ".join(f"[bold]{name}[/bold]: {shows}" for name, shows in PLOTS.items())
            + ".",
            metavar="NAME,...",
            autocompletion=lambda incomplete: complete(incomplete),
        ),
    ] = "torso,zmp,fsr",
    form: Annotated[Literal["png", "svg"], typer.Option("--format", help="Of the files.")] = "png",
    begin: options.Begin = 0.0,
    end: options.End = None,
    robot: options.Body = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Folder for the files; default: the recording's.", metavar="DIR"),
    ] = None,
) -> Answer:
    """Draw plots of recordings, one file each, FILE-NAME.png; later recordings are dashed over the first.

    Those of several are named after their runs, RUN-and-RUN-NAME.png. Those of two name what differs, and those
    over time draw the second less the first, up to a fall.

    Three of them, or those of --what. Bands mark single supports (blue on the left foot, red on the right),
    dotted lines what happened in the world, red lines falls; the axes show the range of a robot on its feet,
    and end half a second after a fall from which it does not get up.

    Example: nao-hil plot runs/20260101T120000Z/frames.mcap --what torso,zmp,fsr

    Example: nao-hil plot walk.mcap --what all --format svg --from 10 --to 15 --out pictures
    """
    names = chosen(what)
    options.check_stretch(begin, end)
    try:
        from nao_hil.analysis.differences import titles
        from nao_hil.analysis.plots.draw import draw, missing
    except ModuleNotFoundError as error:
        raise ConfigurationError(f"Plots need {error.name}: pip install 'nao-hil[analysis]'.") from None

    console = open_console()
    written: list[Path] = []
    with console.status(f"reading {files[0]}") as status:
        runs = [_labelled(file, robot, begin, end) for file in files]
        config, events = _differences(files)
        folder = out if out is not None else files[0].parent
        _make(folder)
        for name in names:
            if what == "all" and any(missing(run, name) for run, _ in runs):
                continue
            status.update(f"drawing {name}")
            written.append(folder / f"{_stem(files)}-{name}.{form}")
            draw(runs, name, written[-1], titles(config, events))
    for path in written:
        console.print(f"written to {path}", soft_wrap=True)
    differ = {"differences": {"config": config, "events": events}} if len(files) == 2 else {}
    return Answer({"files": [str(path) for path in written]} | differ)


def _differences(files: Sequence[Path]) -> tuple[dict[str, list[Any]], list[list[Event]]]:
    """Differences of two recordings; none of other numbers of them."""
    from nao_hil.analysis.differences import config_differences, event_differences

    if len(files) != 2:
        return {}, []
    return config_differences(*files), event_differences(*files)


def _labelled(file: Path, robot: str | None, begin: float, end: float | None) -> tuple[Run, str]:
    """A stretch of a recorded run, and its title in the plots.

    Raises:
        ConfigurationError: it has no sensor frame in that time.
    """
    from nao_hil.runs.run import load

    run = load(file, robot).between(begin, math.inf if end is None else end)
    if not run["sensors"].rows:
        raise ConfigurationError(f"{file}: holds no sensor frame {options.stretch(begin, end)}.")
    return run, ", ".join(word for word in (run.title, run_name(file)) if word)


def chosen(what: str) -> list[str]:
    """Names of plots from a list with commas.

    Raises:
        ConfigurationError: a name that is none.
    """
    if what == "all":
        return list(PLOTS)
    names = [name.strip() for name in what.split(",") if name.strip()]
    for name in names:
        if name not in PLOTS:
            raise ConfigurationError(unknown_name("plot", name, [*PLOTS, "all"]))
    if not names:
        raise ConfigurationError(f"--what is empty; known: {', '.join(PLOTS)}, all")
    return names


def complete(incomplete: str) -> list[str]:
    """Names that complete the part after the last comma."""
    before, comma, last = incomplete.rpartition(",")
    return [f"{before}{comma}{name}" for name in [*PLOTS, "all"] if name.startswith(last)]


def _stem(files: Sequence[Path]) -> str:
    """Name of a picture without the plot's: of the file, or of the first `NAMED` runs."""
    if len(files) == 1:
        return files[0].stem
    more = len(files) - NAMED
    return "-and-".join([*map(run_name, files[:NAMED]), *([f"{more}-more"] if more > 0 else [])])


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigurationError(
            f"{folder}: the folder cannot be made ({error.strerror}); give another with --out."
        ) from None
