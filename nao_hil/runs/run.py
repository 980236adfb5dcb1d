"""A run as arrays: one table for each topic, one row for each message, live or from a recording."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bridge.body import Body
from bridge.errors import ConfigurationError
from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry
from bridge.messages.columns import COLUMNS, OBJECTS, Column
from bridge.messages.topics import Message
from bridge.recording.canonical import RECORDED
from bridge.recording.observer import Observer
from bridge.recording.playback import Recorded, read_recording, recorded_body, recorded_config
from bridge.validation import unknown_name
from nao_hil.arguments import file_path
from nao_hil.runs.folder import recording_of

Array = NDArray[Any]
T = TypeVar("T")
_TIME: Final = Column("s")
TIME_TOLERANCE: Final = 1e-6
"""Difference of two times that are one, s: a file rounds those of its messages to nanoseconds."""
_TOPICS: Final = {RECORDED.get(kind, OBJECTS): columns for kind, columns in COLUMNS.items()}


class Table(Mapping[str, Array]):
    """The messages of one topic: column name to array, first axis the messages.

    A field of a part has both names (`left.force`). A value that is not there is NaN. Arrays kept as
    float32 are given as float64.

    Args:
        columns: Arrays of one length, `time` (robot time, s) among them.
        declared: Unit, frame and elements of each.
    """

    def __init__(self, columns: Mapping[str, Array], declared: Mapping[str, Column] | None = None) -> None:
        self._columns = dict(columns)
        self.columns: Final = {name: (declared or {}).get(name, _TIME) for name in columns}

    def __getitem__(self, column: str) -> Array:
        values = _of(self._columns, "column", column)
        return values.astype(np.float64) if values.dtype == np.float32 else values

    def __repr__(self) -> str:
        """Number of rows, and each column with the length of a row, its unit and its frame."""
        words = []
        for name, (unit, frame, elements) in self.columns.items():
            notes = [str(len(elements))] * bool(elements) + [unit] * bool(unit) + [frame] * bool(frame)
            words.append(f"{name} ({', '.join(notes)})" if notes else name)
        return f"{self.rows} rows of {', '.join(words)}"

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of messages."""
        return len(self["time"])

    def where(self, chosen: Any) -> Table:
        """The table of some rows.

        Args:
            chosen: A mask, indices or a slice.

        Raises:
            ConfigurationError: none of them, or not for these rows.
        """
        try:
            return Table({name: values[chosen] for name, values in self._columns.items()}, self.columns)
        except IndexError as error:
            raise ConfigurationError(f"these rows are not in the table: {error}.") from None

    def until(self, time: float) -> Table:
        """The rows before a time, s."""
        return self.where(self["time"] < time)

    def last(self, column: str, values: ArrayLike) -> NDArray[np.int64]:
        """For each value the row of the last message that is not beyond it in a column; -1: none.

        Example:
            ```python
            walk = run["walk/telemetry"]
            phase = walk["phase"][walk.last("seq", run["sensors"]["seq"])]
            ```
        """
        order = np.argsort(self[column], kind="stable")
        place = np.searchsorted(self[column][order], values, side="right") - 1
        return np.asarray(np.append(order, -1)[place])

    def save(self, file: Path) -> None:
        """Write the arrays as they are kept, as an `.npz`."""
        np.savez_compressed(file, **self._columns)  # type: ignore[arg-type]

    def to_pandas(self) -> Any:
        """The table as a pandas `DataFrame` with the robot time as its index.

        Columns with several values become one for each, named by element (`position.LKneePitch`, `fsr.LFL`).

        Raises:
            ConfigurationError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise ConfigurationError("to_pandas needs pandas; `pip install pandas` brings it.") from None
        flat: dict[str, Array] = {}
        for name, values in self._columns.items():
            elements = self.columns[name].elements
            flat |= {f"{name}.{e}": values[:, i] for i, e in enumerate(elements)} or {name: values}
        return pandas.DataFrame(flat).set_index("time")


class Cycle(NamedTuple):
    """One sensor frame with the messages that belong to it."""

    sensors: SensorFrame
    truth: TruthFrame | None = None
    """Ground truth of the same instant; None on a real robot."""
    walk: WalkTelemetry | None = None
    """The newest word of the walker up to the next frame; None before its first."""
    notices: tuple[Notice, ...] = ()
    """Notices of the robot's side since the frame before."""
    asked: ActuatorFrame | None = None
    """The newest command up to the next frame; None before the first."""


class CycleBuilder:
    """Groups messages into cycles: one is complete when the next sensor frame comes."""

    def __init__(self) -> None:
        self._now: Cycle | None = None
        self._walk: WalkTelemetry | None = None
        self._asked: ActuatorFrame | None = None
        self._notices: list[Notice] = []

    def add(self, message: Message) -> Cycle | None:
        """Take in a message; the cycle that it completes, if it is a sensor frame."""
        complete = None
        if isinstance(message, SensorFrame):
            complete = self.rest()
            if complete is not None and message.seq < complete.sensors.seq:
                self._walk = self._asked = None  # the robot restarted
            self._now = Cycle(message)
        elif isinstance(message, TruthFrame):
            if self._now is not None and message.seq == self._now.sensors.seq:
                self._now = self._now._replace(truth=message)
        elif isinstance(message, WalkTelemetry):
            self._walk = message
        elif isinstance(message, ActuatorFrame):
            self._asked = message
        elif isinstance(message, Notice):
            self._notices.append(message)
        return complete

    def rest(self) -> Cycle | None:
        """The cycle that is under way."""
        if self._now is None:
            return None
        cycle = self._now._replace(walk=self._walk, notices=tuple(self._notices), asked=self._asked)
        self._now, self._notices = None, []
        return cycle


def _unknown_body() -> Body:
    raise ConfigurationError("The run does not say which body it is of.")


class Run(Mapping[str, Table]):
    """A run: topic to table.

    Topics are `sensors`, `actuators`, `world/truth`, `walk/telemetry` and `notices`; one without messages has a
    table without rows. `world/objects` has a row for each object of each ground truth.

    Args:
        messages: Gives all messages in their order, as often as it is called.
        config: Gives the configuration of the run, as plain values; empty: not known.
        body: Makes its robot's data sheet, or raises ConfigurationError.
        tables: By topic; None: made from the messages when they are first asked for.
    """

    def __init__(
        self,
        messages: Callable[[], Iterable[Recorded]] = tuple,
        config: Callable[[], dict[str, Any]] = dict,
        body: Callable[[], Body] = _unknown_body,
        tables: Mapping[str, Table] | None = None,
    ) -> None:
        self.messages, self._config, self._body = messages, config, body
        if tables is not None:
            self._tables = {topic: tables.get(topic) or _table((), _TOPICS[topic]) for topic in _TOPICS}

    @cached_property
    def _tables(self) -> dict[str, Table]:
        rows: dict[str, list[Recorded]] = {topic: [] for topic in _TOPICS}
        for recorded in self.messages():
            rows[recorded.topic].append(recorded)
            if isinstance(recorded.message, TruthFrame):
                rows[OBJECTS] += [recorded._replace(message=one) for one in recorded.message.objects]
        return {topic: _table(rows.pop(topic), columns) for topic, columns in _TOPICS.items()}

    def __getitem__(self, topic: str) -> Table:
        return _of(self._tables, "table", topic)

    def __repr__(self) -> str:
        """A line for each table with messages."""
        tables = (f"{topic}: {table}" for topic, table in self.items() if table.rows)
        return "\n".join(tables) or "no messages"

    def __iter__(self) -> Iterator[str]:
        return iter(_TOPICS)

    def __len__(self) -> int:
        return len(_TOPICS)

    @cached_property
    def config(self) -> dict[str, Any]:
        """Configuration of the run, as plain values; empty: not known."""
        return self._config()

    @cached_property
    def body(self) -> Body:
        """Data sheet of the robot.

        Raises:
            ConfigurationError: the run does not say which body it is of.
        """
        return self._body()

    @property
    def title(self) -> str:
        """Robot, wear, gait and seed, as far as they are known."""
        known = {key: self.config.get(key) for key in ("robot", "wear", "gait", "seed")}
        names = {key: Path(str(value)).name for key, value in known.items() if value not in (None, "")}
        return ", ".join(name if key == "robot" else f"{key} {name}" for key, name in names.items())

    @property
    def fell(self) -> float | None:
        """Robot time at which the robot had fallen by the ground truth, s; None: it did not, or it has none."""
        truth = self["world/truth"]
        return float(truth["time"][truth["fell"].argmax()]) if truth["fell"].any() else None

    def between(self, begin: float, end: float = math.inf) -> Run:
        """The messages of a stretch of robot time, s, ends included."""

        def part(table: Table) -> Table:
            return table.where((begin <= table["time"]) & (table["time"] <= end))

        return Run(
            lambda: (one for one in self.messages() if begin <= one.time <= end),
            lambda: self.config,
            lambda: self.body,
            {topic: part(table) for topic, table in self.items()},
        )

    def aligned(self, topic: str, columns: Iterable[str]) -> Table:
        """Columns of several topics with one row for each message of one topic: of the others the newest one.

        Args:
            topic: A message of it before the first of one of the others has no row.
            columns: Topic and column, as `world/truth.com`; the table has `time` besides.

        Raises:
            ConfigurationError: one text in place of a list.
        """
        if isinstance(columns, str):
            raise ConfigurationError(f"columns is {columns!r}; a list is expected, as [{columns!r}].")
        time = self[topic]["time"]
        names = {name: name.partition(".")[::2] for name in columns}
        newest = {other: self[other].last("time", time + TIME_TOLERANCE) for other, _ in names.values()}
        known = np.all([rows >= 0 for rows in newest.values()], axis=0)
        parts = {name: self[other][column][newest[other][known]] for name, (other, column) in names.items()}
        declared = {name: self[other].columns[column] for name, (other, column) in names.items()}
        return Table({"time": time[known]} | parts, {"time": _TIME} | declared)

    def cycles(self) -> Iterator[Cycle]:
        """The messages cycle by cycle."""
        builder = CycleBuilder()
        for recorded in self.messages():
            if (cycle := builder.add(recorded.message)) is not None:
                yield cycle
        if (last := builder.rest()) is not None:
            yield last


class RunObserver(Observer):
    """Keeps all messages of a run in this process, for its end: a minute takes about 50 MB.

    Args:
        body: The robot's data sheet.
        config: Configuration of the run, as plain values.
    """

    def __init__(self, body: Body, config: dict[str, Any] | None = None) -> None:
        self._messages: list[Recorded] = []
        self._time = 0.0
        self.run = Run(lambda: self._messages, lambda: config or {}, lambda: body)
        """The run; complete at its end."""

    def message(self, message: Message) -> None:
        """Keep a message."""
        if isinstance(message, SensorFrame):
            self._time = message.time
        self._messages.append(Recorded(RECORDED[type(message)], self._time, message))

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """Keep both."""
        self.message(frame)
        self.message(truth)

    def command(self, frame: ActuatorFrame) -> None:
        """Keep the command in force."""
        self.message(frame)


def load(file: str | Path, robot: str | None = None) -> Run:
    """Read a recording (.mcap).

    Example:
        ```python
        run = nao_hil.load("runs/walk")
        print(run)  # its tables, with the unit and the frame of each column
        knee = run["sensors"]["position"][:, nao_hil.JOINTS.index("LKneePitch")]
        run.between(2.0, 5.0)["sensors"].to_pandas().plot(y="position.LKneePitch")
        ```

    Args:
        file: Its path, or that of a run's folder.
        robot: Name of the body; None: the one that the recording names.

    Raises:
        ConfigurationError: no such file, or not a recording; of a damaged one when the first table is read.
    """
    path = recording_of(file_path("file", file))
    read_recording(path)  # a file that is none is reported at once

    def config() -> dict[str, Any]:
        recorded = recorded_config(path)
        return recorded if isinstance(recorded, dict) else {}

    return Run(partial(read_recording, path), config, partial(recorded_body, path, robot))


class _Unknown(ConfigurationError, KeyError):
    """A name that is not there, with those that are."""

    def __str__(self) -> str:
        return str(self.args[0])  # KeyError itself would quote the sentence


def _of(items: dict[str, T], kind: str, name: str) -> T:
    """An item by its name.

    Raises:
        ConfigurationError: there is none; names those that are there. It is a KeyError too.
    """
    try:
        return items[name]
    except KeyError:
        raise _Unknown(unknown_name(kind, name, items)) from None


def _table(rows: Sequence[Recorded], declared: Mapping[str, Column]) -> Table:
    columns = {name: _column([one.message for one in rows], name, declared[name]) for name in declared}
    time = np.array([one.time for one in rows], dtype=np.float64)
    return Table(columns if "time" in columns else columns | {"time": time}, declared)


def _column(messages: Sequence[Any], name: str, declared: Column) -> Array:
    """One row per message; NaN for None, zeros for a row that is left out (lights that are all dark)."""
    part, _, field = name.rpartition(".")
    values = [getattr(getattr(message, part) if part else message, field) for message in messages]
    width = len(declared.elements)
    if not width:
        return np.array(values)
    fill = {None: (math.nan,) * width, (): (0,) * width}
    return np.array([value if value else fill.get(value, value) for value in values]).reshape(-1, width)
