"""A recording as numpy arrays: one table per topic, one row per message."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.body.joints import JOINTS, N_JOINTS
from bridge.errors import ConfigurationError
from bridge.recording.canonical import LEFT_OUT, RECORDED
from bridge.recording.playback import read_recording, recorded_config
from bridge.validation import unknown_name
from nao_hil.arguments import file_path
from nao_hil.runs.folder import recording_of

Array = NDArray[Any]
T = TypeVar("T")
_NO_DATA: Final = LEFT_OUT | {"version"}
"""Fields that a recording leaves out or that mean nothing in it."""


class Table(Mapping[str, Array]):
    """The messages of one topic: field name to array, first axis the messages.

    A field of a part has both names (`left.force`). A value that is not there is NaN.

    Args:
        columns: Arrays of one length, `time` (robot time, s) among them.
    """

    def __init__(self, columns: Mapping[str, Array]) -> None:
        self._columns = dict(columns)

    def __getitem__(self, field: str) -> Array:
        return _of(self._columns, "column", field)

    def __repr__(self) -> str:
        """Number of rows, and each column with the shape of a row's value."""
        shapes = [(name, "x".join(map(str, values.shape[1:]))) for name, values in self._columns.items()]
        return f"{self.rows} rows of {', '.join(f'{name} ({n})' if n else name for name, n in shapes)}"

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of messages."""
        return len(self._columns["time"])

    def to_pandas(self) -> Any:
        """The table as a pandas `DataFrame` with the robot time as its index.

        The columns of a field with several values are named by joint (`position.LKneePitch`) or number
        (`fsr.0`).

        Raises:
            ConfigurationError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise ConfigurationError("to_pandas needs pandas; `pip install pandas` brings it.") from None
        flat: dict[str, Array] = {}
        for name, values in self._columns.items():
            if values.ndim == 1:
                flat[name] = values
            else:
                labels = JOINTS if values.shape[1] == N_JOINTS else range(values.shape[1])
                flat |= {f"{name}.{label}": values[:, i] for i, label in enumerate(labels)}
        return pandas.DataFrame(flat).set_index("time")


class Recording(Mapping[str, Table]):
    """A recording: topic to table.

    Topics are `sensors`, `actuators`, `world/truth`, `walk/telemetry` and `notices`; those with no messages are
    left out.

    Args:
        tables: By topic.
        config: Configuration of the recording, or None.
    """

    def __init__(self, tables: Mapping[str, Table], config: Any) -> None:
        self._tables = dict(tables)
        self.config = config
        """Configuration of the recording, as plain values; None: it holds none."""

    def __getitem__(self, topic: str) -> Table:
        return _of(self._tables, "table", topic)

    def __repr__(self) -> str:
        """A line for each table."""
        return "\n".join(f"{topic}: {table}" for topic, table in self._tables.items()) or "no messages"

    def __iter__(self) -> Iterator[str]:
        return iter(self._tables)

    def __len__(self) -> int:
        return len(self._tables)


class _Unknown(KeyError):
    """A name that is not there, with those that are."""

    def __str__(self) -> str:
        return str(self.args[0])  # KeyError itself would quote the sentence


def _of(items: dict[str, T], kind: str, name: str) -> T:
    """An item by its name.

    Raises:
        KeyError: there is none; names those that are there.
    """
    try:
        return items[name]
    except KeyError:
        raise _Unknown(unknown_name(kind, name, items)) from None


def load(file: str | Path) -> Recording:
    """Read a recording (.mcap).

    Example:
        print(nao_hil.load("runs/walk/frames.mcap"))
        sensors = nao_hil.load("runs/walk/frames.mcap")["sensors"]
        knee = sensors["position"][:, nao_hil.JOINTS.index("LKneePitch")]
        sensors.to_pandas().plot(y="position.LKneePitch")

    Args:
        file: Its path, or that of a run's folder.

    Raises:
        ConfigurationError: no such file, not a recording, or a damaged one.
    """
    file = recording_of(file_path("file", file))
    messages: dict[str, list[msgspec.Struct]] = {topic: [] for topic in RECORDED.values()}
    times: dict[str, list[float]] = {topic: [] for topic in RECORDED.values()}
    for topic, when, message in read_recording(file):
        messages[topic].append(message)
        times[topic].append(when)
    tables = {
        topic: Table({**_columns(rows), "time": np.array(times[topic])})
        for topic, rows in messages.items()
        if rows
    }
    return Recording(tables, recorded_config(file))


def _columns(messages: Sequence[msgspec.Struct], prefix: str = "") -> dict[str, Array]:
    """The fields of messages of one kind; those of a message within follow its name and a dot."""
    columns: dict[str, Array] = {}
    for field in messages[0].__struct_fields__:
        if field in _NO_DATA:
            continue
        values = [getattr(message, field) for message in messages]
        if isinstance(values[0], msgspec.Struct):
            columns |= _columns(values, f"{prefix}{field}.")
        else:
            columns[prefix + field] = _array(values)
    return columns


def _array(values: list[Any]) -> Array:
    """One row per value; a None among tuples becomes a row of NaN."""
    width = next((len(value) for value in values if isinstance(value, tuple)), 0)
    if width and any(value is None for value in values):
        values = [(math.nan,) * width if value is None else value for value in values]
    elif not width:
        values = [math.nan if value is None else value for value in values]
    return np.array(values)
