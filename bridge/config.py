"""Configuration files: TOML checked and converted to msgspec structs; an error names the place of the fault.

Used for every file that a user may write: bodies, gaits, wear profiles, scenarios. An unknown key is an
error with a suggestion, whether or not the struct forbids unknown fields: a silently ignored misspelling
would be a wrong number in an experiment.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any, Final, TypeVar

import msgspec

from bridge.errors import ConfigurationError
from bridge.files import as_text, read_limited
from bridge.validation import Invalid, convert

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

T = TypeVar("T", bound=msgspec.Struct)

MAX_TOML_SIZE: Final = 1 << 18
"""bytes of a TOML file; tomllib needs a second for so many of the slowest kind."""
MAX_KEY_PARTS: Final = 32
"""Most parts of a dotted key: tomllib needs time by their square."""
_OPAQUE: Final = re.compile(
    r'"""(?:[^\\]|\\.)*?(?:"""|\Z)|' r"'''.*?(?:'''|\Z)|" r'"(?:[^"\\\n]|\\.)*"?|' r"'[^'\n]*'?|#[^\n]*",
    re.DOTALL,
)
"""Strings, closed or not, and comments: a dot in them separates nothing."""
_KEY: Final = re.compile(r"[\w.\- \t]+")
"""A key whose strings are left out, or a value."""


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
    right = f"give a readable TOML file of at most {MAX_TOML_SIZE} bytes"
    return _parsed(as_text(read_limited(path, MAX_TOML_SIZE, right), path, right), str(path))


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
    bare = _OPAQUE.sub(lambda found: "s" + "\n" * found[0].count("\n"), text)
    for found in _KEY.finditer(bare):
        if found[0].count(".") >= MAX_KEY_PARTS:
            number = bare.count("\n", 0, found.start()) + 1
            raise ConfigurationError(f"{where}: line {number}: a key of more than {MAX_KEY_PARTS} parts")
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
