"""The newest rows, as lines of JSON that are on the disk before the next walk begins: one file per writer."""

from __future__ import annotations

import fcntl
import os
import socket
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final

import msgspec

from nao_hil.runs.store import Row

SUFFIX: Final = ".jsonl"


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
