"""Files that a person names: regular ones only, each read within a bound of length.

Devices, pipes and folders are refused before they are opened, so that no reader waits for them. Work after the
reading is linear in the length, or has a bound of its own beside the reader.
"""

from __future__ import annotations

import csv
import gzip
import io
import stat
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final, NamedTuple

from bridge.errors import ConfigurationError

MAX_TABLE_SIZE: Final = 1 << 26
"""bytes of a table, unpacked; ten minutes of all signals of a robot have half of it."""
MAX_TABLE_CELLS: Final = 1 << 23
_MAX_COLUMNS: Final = 1 << 12


def open_file(path: str | Path, right: str) -> BinaryIO:
    """Open a regular file for reading.

    Args:
        path: the file.
        right: the remedy, for the error, for example `give a recording (.mcap)`.

    Raises:
        ConfigurationError: unreadable, or not a regular file.
    """
    try:
        mode = Path(path).stat().st_mode
        if not stat.S_ISREG(mode):
            kind = "folder" if stat.S_ISDIR(mode) else "device or a pipe"
            raise ConfigurationError(f"{path}: is a {kind}; {right}.")
        return Path(path).open("rb")
    except (OSError, ValueError) as error:  # a zero byte in the path is a ValueError
        why = getattr(error, "strerror", None) or str(error)
        raise ConfigurationError(f"{path}: cannot be read ({why}); {right}.") from error


def read_limited(path: str | Path, limit: int, right: str) -> bytes:
    """Content of a regular file of limited length.

    Args:
        path: the file.
        limit: bytes.
        right: the remedy, for the error, for example `give a readable TOML file`.

    Raises:
        ConfigurationError: unreadable, not a regular file, or too long.
    """
    try:
        with open_file(path, right) as file:
            if Path(path).stat().st_size <= limit:
                data = file.read(limit + 1)  # a file of /proc is longer than its size
                if len(data) <= limit:
                    return data
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read ({error.strerror}); {right}.") from error
    raise ConfigurationError(f"{path}: has more than {limit} bytes; {right}.")


def as_text(data: bytes, path: str | Path, right: str) -> str:
    """Content of a file in UTF-8, without a byte order mark.

    Raises:
        ConfigurationError: another encoding.
    """
    try:
        return data.decode("utf-8-sig")
    except ValueError as error:
        raise ConfigurationError(f"{path}: is not a text in UTF-8 ({error}); {right}.") from None


class Row(NamedTuple):
    """A row of a table."""

    line: int
    """In the file, from 1."""
    cells: list[str]
    """Without blanks around them."""


def read_table(path: Path, right: str, limit: int = MAX_TABLE_SIZE) -> Iterator[Row]:
    """Rows of a CSV or a .csv.gz: cells between commas; empty lines and those that begin with `#` are left out.

    The file is read by the first row that is taken.

    Args:
        path: the file.
        right: the remedy, for errors.
        limit: bytes, unpacked.

    Raises:
        ConfigurationError: unreadable, too long, no text, or a row with more or fewer cells than the first.
    """
    data = read_limited(path, limit, right)
    if path.suffix.lower() == ".gz":
        try:
            data = gzip.GzipFile(fileobj=io.BytesIO(data)).read(limit + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise ConfigurationError(f"{path}: cannot be unpacked ({error}); {right}.") from None
        if len(data) > limit:
            raise ConfigurationError(f"{path}: is longer than {limit} bytes unpacked; {right}.")
    text = as_text(data, path, right)
    if text.count(",") > MAX_TABLE_CELLS:
        raise ConfigurationError(f"{path}: has more than {MAX_TABLE_CELLS} cells; {right}.")
    width = 0
    try:
        for number, line in enumerate(io.StringIO(text, newline=None), 1):
            if not line.strip() or line.startswith("#"):
                continue
            (cells,) = csv.reader([line], strict=True)
            width = width or len(cells)
            if len(cells) != width or width > _MAX_COLUMNS:
                few = (
                    f"its first row has {width}"
                    if width <= _MAX_COLUMNS
                    else f"at most {_MAX_COLUMNS} are read"
                )
                raise ConfigurationError(f"{path}, line {number}: has {len(cells)} cells; {few}; {right}.")
            yield Row(number, [cell.strip() for cell in cells])
    except csv.Error as error:
        raise ConfigurationError(
            f"{path}, line {number}: is no row of a CSV file ({error}); {right}."
        ) from None
