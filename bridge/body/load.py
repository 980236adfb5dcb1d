"""Finding and reading the data sheets."""

from __future__ import annotations

import functools
import os
from pathlib import Path
from typing import Final

from bridge.body.check import check_body
from bridge.body.model import Body
from bridge.config import load_toml
from bridge.errors import ConfigurationError
from bridge.validation import unknown_name

BODIES: Final = ("nao-v3", "nao-v3.2", "nao-v3.3", "nao-v4", "nao-v5", "nao-v6")
"""The data sheets that come with the package; `nao-v3` is the robot of Prenner's thesis."""

_FOLDER: Final = Path(__file__).parent / "bodies"


def load_body(name_or_path: str | os.PathLike[str]) -> Body:
    """A robot body, read and checked.

    Args:
        name_or_path: one of `BODIES`, or the path of a TOML file (ends with `.toml` or names a folder).

    Raises:
        ConfigurationError: no such body, or a sheet that is misspelt, incomplete or impossible.
    """
    name = os.fspath(name_or_path)
    if name in BODIES:
        return _shipped(name)
    if not name.endswith(".toml") and Path(name).name == name:
        raise ConfigurationError(f"{unknown_name('robot body', name, BODIES)}, or the path of a .toml file")
    return _read(Path(name))


@functools.cache
def _shipped(name: str) -> Body:
    return _read(_FOLDER / f"{name}.toml")


def _read(path: Path) -> Body:
    body = load_toml(path, Body)
    try:
        check_body(body)
        if body.base not in BODIES:
            raise ConfigurationError(f"base: {unknown_name('shipped body', body.base, BODIES)}")
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {error}") from None
    return body
