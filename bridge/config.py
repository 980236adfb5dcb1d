"""Configuration files: TOML checked and converted to msgspec structs; an error names the place of the fault.

Used for every file that a user may write: bodies, gaits, wear profiles, scenarios. An unknown key is an
error with a suggestion, whether or not the struct forbids unknown fields: a silently ignored misspelling
would be a wrong number in an experiment.
"""

from __future__ import annotations

import stat
import sys
from pathlib import Path
from typing import Any, Final, TypeVar

import msgspec

from bridge.errors import ConfigurationError
from bridge.validation import Invalid, convert

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

T = TypeVar("T", bound=msgspec.Struct)

MAX_TOML_SIZE: Final = 1 << 18
"""bytes of a TOML file; tomllib needs a second for so many of the slowest kind."""
MAX_KEY_PARTS: Final = 32
"""Of a dotted key: tomllib needs time by their square."""


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
        status = Path(path).stat()
        if not stat.S_ISREG(status.st_mode):
            kind = "folder" if stat.S_ISDIR(status.st_mode) else "device or a pipe"
            raise ConfigurationError(f"{path}: is a {kind}; {right}.")
        if status.st_size <= limit:
            with Path(path).open("rb") as file:
                data = file.read(limit + 1)  # a file of /proc is longer than its size
            if len(data) <= limit:
                return data
    except (OSError, ValueError) as error:  # a zero byte in the path is a ValueError
        why = getattr(error, "strerror", None) or str(error)
        raise ConfigurationError(f"{path}: cannot be read ({why}); {right}.") from error
    raise ConfigurationError(f"{path}: has more than {limit} bytes; {right}.")


def load_toml(path: str | Path, kind: type[T]) -> T:
    """Read one TOML file as a struct.

    Args:
        path: the file.
        kind: msgspec struct that names every allowed key and its type.

    Raises:
        ConfigurationError: unreadable, not TOML, or not a `kind`; names the file and the key.
    """
    return from_dict(read_toml(path), str(path), kind)


def read_toml(path: str | Path) -> dict[str, Any]:
    """Read one TOML file of any kind.

    Raises:
        ConfigurationError: unreadable, or not TOML.
    """
    data = read_limited(path, MAX_TOML_SIZE, f"give a readable TOML file of at most {MAX_TOML_SIZE} bytes")
    try:
        text = data.decode("utf-8-sig")
    except ValueError as error:
        raise ConfigurationError(f"{path}: is not a UTF-8 text file ({error}); TOML is UTF-8.") from error
    return _parsed(text, str(path))


def parse_toml(text: str, where: str, kind: type[T]) -> T:
    """Parse TOML text into a struct.

    Args:
        text: the TOML.
        where: begins every error message; a file name.
        kind: msgspec struct that names every allowed key and its type.

    Raises:
        ConfigurationError: not TOML, or not a `kind`.
    """
    return from_dict(_parsed(text, where), where, kind)


def _parsed(text: str, where: str) -> dict[str, Any]:
    if len(text) > MAX_TOML_SIZE:
        raise ConfigurationError(f"{where}: has more than {MAX_TOML_SIZE} letters, which no TOML file may have")
    for number, line in enumerate(text.splitlines(), 1):
        # A list of numbers has commas between its dots.
        if line.count(".") > MAX_KEY_PARTS and _key_parts(line) > MAX_KEY_PARTS:
            raise ConfigurationError(f"{where}: line {number}: a key of more than {MAX_KEY_PARTS} parts")
    try:
        data: dict[str, Any] = tomllib.loads(text)
    except RecursionError as error:
        raise ConfigurationError(f"{where}: is nested too deeply to be read") from error
    except ValueError as error:  # TOMLDecodeError, and numbers Python refuses to read
        raise ConfigurationError(f"{where}: is not valid TOML: {error}") from error
    return data


def _key_parts(line: str) -> int:
    """Most parts of a dotted key in a line of TOML; spaces around the dots do not end it."""
    return max(word.count(".") for word in "".join(line.split()).split(",")) + 1


def from_dict(data: dict[str, Any], where: str, kind: type[T]) -> T:
    """As `parse_toml`, for data already read: a table of a larger file, or command-line options."""
    try:
        config: T = convert(data, kind)
    except Invalid as error:
        raise ConfigurationError(f"{where}: {error}") from error
    return config
