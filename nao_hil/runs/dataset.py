"""A folder of walks: a journal, parts of Parquet that are never changed, and tracks where they are kept.

A row is a walk, under the key of all that it depends on. The newest rows are lines of JSON, on the disk before
the next walk begins: one file per writer.
"""

from __future__ import annotations

import fcntl
import os
import socket
import uuid
import zipfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final

import msgspec
import numpy as np
import pyarrow as pa
import pyarrow.dataset as pads
import pyarrow.parquet as pq

from bridge.errors import ConfigurationError
from nao_hil.files import atomic_path
from nao_hil.runs.run import Table
from nao_hil.runs.store import Row, row
from nao_hil.runs.walk import NO_TRACK, Walk, WalkOutcome

PATTERN: Final = "part-*.parquet"
_TYPES: Final = {"str": pa.string(), "int": pa.int64(), "float": pa.float64(), "bool": pa.bool_()}
SCHEMA: Final = pa.schema([(name, _TYPES.get(kind, pa.string())) for name, kind in Row.__annotations__.items()])
"""Columns of a part: the fields of `Row`."""
SUFFIX: Final = ".jsonl"
"""Of a journal."""


def write_part(folder: Path, rows: Sequence[Row]) -> Path:
    """Write rows as a new part; it is there whole or not at all."""
    path = folder / f"part-{uuid.uuid4().hex}.parquet"
    half = path.with_suffix(".half")
    table = pa.Table.from_pylist([msgspec.structs.asdict(row) for row in rows], schema=SCHEMA)
    with half.open("wb") as file:
        pq.write_table(table, file, compression="zstd")
        file.flush()
        os.fsync(file.fileno())
    half.rename(path)
    return path


def find_rows(folder: Path, keys: Collection[str]) -> dict[str, Row]:
    """The rows of some keys.

    Raises:
        ConfigurationError: a part that cannot be read.
    """
    return {found["key"]: msgspec.convert(found, Row) for found in _read(folder, keys, None).to_pylist()}


def known_keys(folder: Path, keys: Collection[str]) -> set[str]:
    """Which of some keys have a row; raises as `find_rows`."""
    return set(_read(folder, keys, ["key"]).column("key").to_pylist())


def _read(folder: Path, keys: Collection[str], columns: list[str] | None) -> pa.Table:
    files = sorted(map(str, folder.glob(PATTERN)))
    if not files or not keys:
        return SCHEMA.empty_table()
    try:
        parts = pads.dataset(files, schema=SCHEMA, format="parquet")
        return parts.to_table(columns=columns, filter=pads.field("key").isin(sorted(keys)))
    except (pa.ArrowInvalid, OSError) as error:
        raise ConfigurationError(
            f"{folder}: a part of the results cannot be read ({str(error).splitlines()[0]}); remove that file, "
            "and its walks are walked again."
        ) from None


class Journal:
    """A file that this process alone writes; its lock shows others that its writer is alive."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / f"{socket.gethostname()}-{os.getpid()}-{uuid.uuid4().hex[:8]}{SUFFIX}"
        self._file = self.path.open("ab")
        fcntl.flock(self._file, fcntl.LOCK_EX)

    def append(self, row: Row) -> None:
        """Write a row; on the disk when this returns."""
        self._file.write(msgspec.json.encode(row) + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def remove(self) -> None:
        """Its rows are elsewhere now."""
        self.path.unlink()
        self._file.close()


def rows_of(path: Path) -> list[Row]:
    """The rows of a journal; the last line of a killed writer may be half, and is none."""
    rows = []
    for line in path.read_bytes().splitlines():
        try:
            rows.append(msgspec.json.decode(line, type=Row))
        except msgspec.DecodeError:
            continue
    return rows


@contextmanager
def abandoned(folder: Path) -> Iterator[list[Path]]:
    """The journals of a folder whose writers have ended; locked while in the context."""
    with ExitStack() as held:
        paths = []
        for path in sorted(folder.glob(f"*{SUFFIX}")):
            try:
                file = held.enter_context(path.open("rb"))
            except FileNotFoundError:
                continue
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                os.stat(path)  # missing if another process has taken it
            except OSError:
                continue
            paths.append(path)
        yield paths


ROWS_PER_PART: Final = 5000
"""Rows of a part."""


class Dataset:
    """Walks, each once.

    A row is on the disk when `put` returns. Rows of a killed writer are taken in when the folder
    is next opened.

    Args:
        folder: Made if it is not there.
        rows: Of a part.

    Raises:
        ConfigurationError: the folder cannot be made or written.
    """

    def __init__(self, folder: Path, rows: int = ROWS_PER_PART) -> None:
        self._folder, self._rows = folder, rows
        self._recent: dict[str, Row] = {}
        self._journal: Journal | None = None
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._take_in()
        except OSError as error:
            raise ConfigurationError(
                f"{folder}: the folder for the walks cannot be written ({error.strerror}); give a writable one."
            ) from None

    def find(self, walks: Mapping[str, Walk]) -> dict[str, WalkOutcome]:
        """Finished walks among these, by key; one with an unreadable track counts as not walked."""
        recent = {key: self._recent[key] for key in walks if key in self._recent}
        rows = find_rows(self._folder, walks.keys() - recent.keys()) | recent
        outcomes = {}
        for key, known in rows.items():
            if (track := self._track(known)) is not None:
                outcomes[key] = WalkOutcome(walks[key], known.end, track)
        return outcomes

    def put(self, result: WalkOutcome, seconds: float) -> None:
        """Keep a walk.

        Args:
            result: The walk.
            seconds: Wall time that it took.
        """
        new = row(result, seconds)
        if new.track:
            self._keep_track(new.key, result.track)
        if self._journal is None:
            self._journal = Journal(self._folder / "journal")
        if new.key not in self._recent:
            self._journal.append(new)
            self._recent[new.key] = new
        if len(self._recent) >= self._rows:
            self._compact()

    def close(self) -> None:
        """Put the journal's rows into a part."""
        if self._journal is not None:
            self._compact()

    def _compact(self) -> None:
        assert self._journal is not None
        with self._lock():
            self._add(list(self._recent.values()))
            self._journal.remove()
        self._journal = None
        self._recent.clear()

    def _take_in(self) -> None:
        with self._lock(), abandoned(self._folder / "journal") as journals:
            rows = {row.key: row for path in journals for row in rows_of(path)}
            self._add(list(rows.values()))
            for path in journals:
                path.unlink()

    def _add(self, rows: Sequence[Row]) -> None:
        """Write those of the rows whose keys no part has; the lock is held."""
        known = known_keys(self._folder, [row.key for row in rows])
        if new := [row for row in rows if row.key not in known]:
            write_part(self._folder, new)

    @contextmanager
    def _lock(self) -> Iterator[None]:
        """One process at a time makes parts, so that no two have the same walk."""
        with (self._folder / ".lock").open("wb") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield

    def _track(self, known: Row) -> Table | None:
        if not known.track:
            return NO_TRACK
        try:
            with self._track_file(known.key).open("rb") as file, np.load(file) as data:
                return Table({name: data[name] for name in NO_TRACK}, NO_TRACK.columns)
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None

    def _keep_track(self, key: str, track: Table) -> None:
        path = self._track_file(key)
        path.parent.mkdir(exist_ok=True)
        with atomic_path(path) as temporary:
            track.save(temporary)

    def _track_file(self, key: str) -> Path:
        return self._folder / "tracks" / f"{key}.npz"
