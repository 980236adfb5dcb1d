"""A folder of walks: a journal, parts, and tracks where they were kept."""

from __future__ import annotations

import fcntl
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import numpy as np

from bridge.errors import ConfigurationError
from nao_hil.files import atomic_path
from nao_hil.runs.dataset.journal import Abandoned, Journal, rows_of
from nao_hil.runs.dataset.parts import find_rows, known_keys, write_part
from nao_hil.runs.dataset.row import Row, row
from nao_hil.runs.track import WIDTH, Track
from nao_hil.runs.walk import Walk, WalkOutcome

ROWS: Final = 5000
"""Of a part."""
_EMPTY: Final = Track(np.zeros((0, WIDTH), dtype=np.float32))


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

    def __init__(self, folder: Path, rows: int = ROWS) -> None:
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
        """Those that were walked before, by key; one whose track cannot be read counts as not walked.

        Args:
            walks: By key.
        """
        recent = {key: self._recent[key] for key in walks if key in self._recent}
        rows = find_rows(self._folder, walks.keys() - recent.keys()) | recent
        found = {}
        for key, known in rows.items():
            if (track := self._track(known)) is not None:
                found[key] = WalkOutcome(walks[key], known.end, track)
        return found

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
        with self._lock(), Abandoned(self._folder / "journal") as journals:
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

    def _track(self, known: Row) -> Track | None:
        if not known.track:
            return _EMPTY
        try:
            with self._track_file(known.key).open("rb") as file, np.load(file) as data:
                return Track(data["rows"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None

    def _keep_track(self, key: str, track: Track) -> None:
        path = self._track_file(key)
        path.parent.mkdir(exist_ok=True)
        with atomic_path(path) as temporary:
            np.savez_compressed(temporary, rows=track.rows)

    def _track_file(self, key: str) -> Path:
        return self._folder / "tracks" / f"{key}.npz"
