"""A CSV of times, commands and measurements, as other robots and programs can write it."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.body.joints import INDEX, degrees_warning
from bridge.config import load_toml
from bridge.errors import ConfigurationError
from bridge.files import Row, read_table
from bridge.types import Array
from nao_hil.identification.readings import COMMANDS, NAMES, LoggedRun, specific_force

COLUMNS: Final = {
    f"{name}.{label}": (name, number) for name, labels in NAMES.items() for number, label in enumerate(labels)
}
"""Column of the file to signal and its column there: `command.LKneePitch`, `gyroscope.x`, `fsr.LFL`."""
COMMAND_TIME: Final = "command.time"
"""Column of the commands' times, on a clock of their own."""
MEASURED: Final = tuple(name for name in NAMES if name not in COMMANDS)
_KNOWN: Final = ("time", COMMAND_TIME, *COLUMNS)


class Column(msgspec.Struct, frozen=True, kw_only=True):
    """A column of a file with names of its own."""

    column: str
    scale: float = 1.0
    """Factor to SI units or radians."""


class ColumnMap(msgspec.Struct, frozen=True, kw_only=True):
    """Mapping of a file's columns; the others are not read."""

    columns: dict[str, str | Column]
    """Names of `COLUMNS`, `time` and `command.time` to the file's; `*` in both is every joint or axis."""
    rate: float | None = None
    """Rows per second of a file without times."""


class _Table(NamedTuple):
    names: list[str]
    """As the project calls the columns."""
    values: Array
    """(rows, columns); NaN where a cell is empty."""
    lines: Array
    """Line of each row, (rows,)."""


def read_csv(path: Path, mapping: Path | None = None) -> LoggedRun:
    """Read a file whose first line names its columns: `time`, `command.time` and any of `COLUMNS`.

    An empty cell holds no value.

    Args:
        path: .csv or .csv.gz.
        mapping: TOML of a `ColumnMap`, or the name of one beside this module; None: the file has the project's
            names. The accelerometer of a mapped file may show gravity, or count in g.

    Raises:
        ConfigurationError: unreadable, an unknown or missing column, times that do not rise, or a cell that is
            no number; names the line and the column.
    """
    if mapping is not None and not mapping.exists():
        shipped = Path(__file__).with_name(f"{mapping.name}.toml")
        mapping = shipped if shipped.is_file() else mapping
    given = None if mapping is None else load_toml(mapping, ColumnMap)
    table = _read_table(path, given, mapping)
    if len(table.values) < 2:
        raise ConfigurationError(f"{path}: has {len(table.values)} rows of numbers; at least two are needed.")
    own_clock = COMMAND_TIME in table.names
    time, measured = _signals(path, table, "time", MEASURED)
    command_time, commands = _signals(path, table, COMMAND_TIME if own_clock else "time", COMMANDS)
    notes: tuple[str, ...] = ()
    if given is not None and np.isfinite(measured.get("accelerometer", np.nan)).any(axis=0).all():
        force, notes = specific_force(measured["accelerometer"], measured.get("angle"))
        measured = {**measured, "accelerometer": force}
    return LoggedRun(time, measured, command_time, commands, own_clock, notes)


def _read_table(path: Path, given: ColumnMap | None, mapping: Path | None) -> _Table:
    lines = read_table(path, "give a CSV file with a line for each time")
    head = next(lines, Row(1, [])).cells
    _check_head(path, head, known=given is None)
    columns = {name: Column(column=name) for name in head} if given is None else _mapped(given, head, mapping)
    names, rate = list(columns), None if given is None else given.rate
    _check_names(path, names if rate is None else [*names, "time"])
    places = [head.index(columns[name].column) for name in names]
    rows, numbers = [], []
    for line, cells in lines:
        rows.append([_number(path, line, head[place], cells[place]) for place in places])
        numbers.append(line)
    values = np.array(rows).reshape(len(rows), len(names)) * [columns[name].scale for name in names]
    if rate is not None:
        names, values = [*names, "time"], np.column_stack([values, np.arange(len(rows)) / rate])
    _check_degrees(path, names, values)
    return _Table(names, values, np.array(numbers))


def _check_degrees(path: Path, names: Sequence[str], values: Array) -> None:
    """Raises ConfigurationError on angles that no joint reaches."""
    for column, name in enumerate(names):
        signal, _, joint = name.partition(".")
        if joint not in INDEX or signal not in ("command", "position"):
            continue
        farthest = np.nanmax(np.abs(values[:, column]), initial=0.0)
        if why := degrees_warning(joint, float(farthest)):
            raise ConfigurationError(f"{path}: {why} --columns gives a column's scale.")


def _check_head(path: Path, head: Sequence[str], *, known: bool) -> None:
    """Raises ConfigurationError on a column that is there twice, or is not the project's."""
    for column, name in enumerate(head, 1):
        where = f"{path}, line 1, column {column}"
        if known and name not in _KNOWN:
            raise ConfigurationError(
                f"{where}: unknown column `{name}`{_hint(name, _KNOWN)}; columns are `time` and such as "
                "`command.LKneePitch`, `position.LKneePitch`, `gyroscope.x`, `fsr.LFL`; --columns maps others."
            )
        if name in head[: column - 1]:
            raise ConfigurationError(f"{where}: `{name}` is there twice.")


def _check_names(path: Path, names: Sequence[str]) -> None:
    """Raises ConfigurationError unless these columns make a recording."""
    if "time" not in names:
        raise ConfigurationError(f"{path}, line 1: no column `time`; each row needs its time in s.")
    signals = {COLUMNS[name][0] for name in names if name in COLUMNS}
    if not signals & set(MEASURED) or ("command" in signals and "position" not in signals):
        example = "position.LKneePitch" if signals else "gyroscope.x"
        raise ConfigurationError(f"{path}, line 1: no column `{example}` or alike; measurements are needed.")


def _mapped(given: ColumnMap, head: Sequence[str], mapping: Path | None) -> dict[str, Column]:
    """Columns by the project's name; raises ConfigurationError on a name of neither side."""
    by_name: dict[str, Column] = {}
    for key, value in given.columns.items():
        each = Column(column=value) if isinstance(value, str) else value
        signal, _, label = key.partition(".")
        if key not in _KNOWN and not (label == "*" and signal in NAMES):
            raise ConfigurationError(f"{mapping}: unknown name `{key}`{_hint(key, _KNOWN)}.")
        labels = NAMES[signal] if label == "*" else (label,)
        columns = {
            key.replace("*", name): Column(column=each.column.replace("*", name), scale=each.scale)
            for name in labels
        }
        present = {name: column for name, column in columns.items() if column.column in head}
        if not present:
            raise ConfigurationError(
                f"{mapping}, {key}: the file has no column `{each.column}`{_hint(each.column, head)}."
            )
        by_name |= present
    return by_name


def _hint(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, list(known), 1)
    return f" (did you mean `{near[0]}`?)" if near else ""


def _number(path: Path, line: int, name: str, cell: str) -> float:
    if not cell:
        return math.nan
    try:
        number = float(cell)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ConfigurationError(f"{path}, line {line}, column {name}: `{cell}` is no finite number.")
    return number


def _signals(path: Path, table: _Table, clock: str, wanted: Sequence[str]) -> tuple[Array, Mapping[str, Array]]:
    """Times and those signals that the table has, of the rows that have a time on this clock and a value."""
    signals: dict[str, Array] = {}
    for column, name in enumerate(table.names):
        signal, number = COLUMNS.get(name, ("", 0))
        if signal in wanted:
            values = signals.setdefault(signal, np.full((len(table.values), len(NAMES[signal])), math.nan))
            values[:, number] = table.values[:, column]
    time = table.values[:, table.names.index(clock)]
    valued = [np.isfinite(values).any(axis=1) for values in signals.values()]
    rows = np.isfinite(time) & np.any([np.zeros(len(time), dtype=bool), *valued], axis=0)
    time, lines = time[rows], table.lines[rows]
    stops = np.flatnonzero(np.diff(time) <= 0.0)
    if len(stops):
        at = stops[0]
        raise ConfigurationError(
            f"{path}, line {lines[at + 1]}, column {clock}: {time[at + 1]:g} s is not after the {time[at]:g} s "
            "of the row before."
        )
    if signals and len(time) < 2:
        raise ConfigurationError(
            f"{path}: has {len(time)} rows with a value and a `{clock}`; at least two are needed."
        )
    return time, {name: values[rows] for name, values in signals.items()}
