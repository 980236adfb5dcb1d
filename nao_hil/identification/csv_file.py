"""A CSV of time, commands and measurements, as other robots and programs can write it."""

from __future__ import annotations

import csv
import difflib
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from bridge.config import read_limited
from bridge.errors import ConfigurationError
from nao_hil.identification.signals import NAMES, Array

MAX_CSV: Final = 1 << 26
"""bytes of a file of measurements."""
COLUMNS: Final = {
    f"{name}.{label}": (name, number) for name, labels in NAMES.items() for number, label in enumerate(labels)
}
"""Column of the file to signal and its column there: `command.LKneePitch`, `gyroscope.x`, `fsr.LFL`."""


def read_csv(path: Path) -> tuple[Array, dict[str, Array]]:
    """Read a file whose first line names its columns: `time` and any of `COLUMNS`.

    Returns:
        Times in s, (n,), and the signals that the file has, (n, width); NaN where a column is missing.

    Raises:
        ConfigurationError: unreadable, an unknown or missing column, or a cell that is no number; names the
            line and the column.
    """
    data = read_limited(path, MAX_CSV, f"give a CSV file of at most {MAX_CSV} bytes")
    try:
        lines = csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""))
        names = [name.strip() for name in next(lines, [])]
        _check_head(path, names)
        rows = [_row(path, lines.line_num, names, cells) for cells in lines if cells]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigurationError(f"{path}: is not a CSV file in UTF-8 ({error}).") from None
    if len(rows) < 2:
        raise ConfigurationError(f"{path}: has {len(rows)} rows of numbers; at least two are needed.")
    table = np.array(rows)
    time = table[:, names.index("time")]
    stops = np.flatnonzero(np.diff(time) <= 0.0)
    if len(stops):
        raise ConfigurationError(
            f"{path}, line {stops[0] + 3}, column time: {time[stops[0] + 1]:g} s is not after the "
            f"{time[stops[0]]:g} s of the line before."
        )
    return time, _signals(names, table)


def _check_head(path: Path, names: Sequence[str]) -> None:
    for column, name in enumerate(names, 1):
        where = f"{path}, line 1, column {column}"
        if name != "time" and name not in COLUMNS:
            near = difflib.get_close_matches(name, COLUMNS, 1)
            hint = f" (did you mean `{near[0]}`?)" if near else ""
            raise ConfigurationError(
                f"{where}: unknown column `{name}`{hint}; columns are `time` and such as `command.LKneePitch`, "
                "`position.LKneePitch`, `gyroscope.x`, `fsr.LFL`."
            )
        if name in names[: column - 1]:
            raise ConfigurationError(f"{where}: `{name}` is there twice.")
    for needed in ("time", "command.", "position."):
        if not any(name.startswith(needed) for name in names):
            example = needed if needed == "time" else f"{needed}LKneePitch"
            raise ConfigurationError(
                f"{path}, line 1: no column `{example}`; time, commands and angles are needed."
            )


def _row(path: Path, line: int, names: Sequence[str], cells: Sequence[str]) -> list[float]:
    if len(cells) != len(names):
        raise ConfigurationError(f"{path}, line {line}: has {len(cells)} cells; its head has {len(names)}.")
    numbers = []
    for name, cell in zip(names, cells, strict=True):
        try:
            number = float(cell)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise ConfigurationError(
                f"{path}, line {line}, column {name}: `{cell.strip()}` is no finite number."
            )
        numbers.append(number)
    return numbers


def _signals(names: Sequence[str], table: Array) -> dict[str, Array]:
    signals: dict[str, Array] = {}
    for column, name in enumerate(names):
        if name in COLUMNS:
            signal, number = COLUMNS[name]
            values = signals.setdefault(signal, np.full((len(table), len(NAMES[signal])), math.nan))
            values[:, number] = table[:, column]
    return signals
