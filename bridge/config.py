"""Configuration files: TOML in, a checked msgspec struct out, or one sentence that says what is wrong where.

Used for every file a person may write: bodies, gaits, wear profiles, scenarios. A key nobody knows is an
error with a suggestion, whether or not the struct forbids unknown fields: a silently ignored misspelling
would be a wrong number in an experiment.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from bridge.errors import ConfigurationError
from bridge.validation import Invalid, convert

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

T = TypeVar("T", bound=msgspec.Struct)


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
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise ConfigurationError(
            f"{path}: cannot be read ({error.strerror}); give a readable TOML file."
        ) from error
    except ValueError as error:
        raise ConfigurationError(f"{path}: is not a UTF-8 text file ({error}); TOML is UTF-8.") from error
    return _parsed(text, str(path))


def parse_toml(text: str, where: str, kind: type[T]) -> T:
    """TOML text as a struct.

    Args:
        text: the TOML.
        where: begins every error message; a file name.
        kind: msgspec struct that names every allowed key and its type.

    Raises:
        ConfigurationError: not TOML, or not a `kind`.
    """
    return from_dict(_parsed(text, where), where, kind)


def _parsed(text: str, where: str) -> dict[str, Any]:
    try:
        data: dict[str, Any] = tomllib.loads(text)
    except RecursionError as error:
        raise ConfigurationError(f"{where}: is nested too deeply to be read") from error
    except ValueError as error:  # TOMLDecodeError, and numbers Python refuses to read
        raise ConfigurationError(f"{where}: is not valid TOML: {error}") from error
    return data


def from_dict(data: dict[str, Any], where: str, kind: type[T]) -> T:
    """As `parse_toml`, for data already read: a table of a larger file, or command-line options."""
    try:
        config: T = convert(data, kind)
    except Invalid as error:
        raise ConfigurationError(f"{where}: {error}") from error
    return config
