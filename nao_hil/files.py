"""Files that are written whole or not at all."""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from bridge.errors import ConfigurationError

DISK_FULL_ERRORS: Final = (errno.ENOSPC, errno.EDQUOT)
"""Errors of a disk, or of one's share of it, that is full."""


@contextmanager
def atomic_path(file: Path) -> Iterator[Path]:
    """A path to write to; it takes a file's place where the block ends well, else nothing of it is left.

    Example:
        with atomic_path(file) as temporary:
            model.save(temporary)

    Args:
        file: To write; an existing one stays as it is until then. A device or a pipe is written to at once.

    Yields:
        The path of another file in the same folder, with the same suffix.

    Raises:
        ConfigurationError: the file cannot be written.
        OSError: the disk is full; the command line reports it.
    """
    temporary: Path | None = None
    try:
        place = file.resolve()  # a link stays a link
        if place.exists() and not place.is_file():
            yield place
            return
        temporary = place.with_name(f".{place.stem}.{os.getpid()}{place.suffix}")
        yield temporary
        temporary.replace(place)
    except OSError as error:
        if error.errno in DISK_FULL_ERRORS:
            raise
        raise ConfigurationError(f"{file}: cannot be written ({error.strerror}); give another place.") from None
    finally:
        if temporary is not None:
            with suppress(OSError):  # where it took the file's place, or could not even begin
                temporary.unlink()


def write_text(file: Path, text: str) -> None:
    """Write a text in UTF-8, whole or not at all.

    Raises:
        ConfigurationError: the file cannot be written.
    """
    with atomic_path(file) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_bytes(file: Path, data: bytes) -> None:
    """Write bytes, whole or not at all.

    Raises:
        ConfigurationError: the file cannot be written.
    """
    with atomic_path(file) as temporary:
        temporary.write_bytes(data)


def save_figure(figure: Any, file: Path) -> Path:
    """Write a figure of Matplotlib as PNG, or in the format that the file's name has; gives its path.

    Raises:
        ConfigurationError: the file cannot be written.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(file) as temporary, warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", 'Creating legend with loc="best"'
        )  # it times itself, on a busy machine too
        figure.savefig(temporary, dpi=110)
    return file
