"""Arguments of the public functions: what each must be, and one sentence about one that is not."""

from __future__ import annotations

import operator
import os
from pathlib import Path
from typing import SupportsIndex

from bridge.errors import ConfigurationError


def whole_seed(seed: SupportsIndex) -> int:
    """A seed as a number of Python's own.

    Raises:
        ConfigurationError: no whole number from 0 on.
    """
    try:
        number = -1 if isinstance(seed, bool) else operator.index(seed)
    except TypeError:
        number = -1
    if number < 0:
        raise ConfigurationError(f"A seed is {seed!r}; a whole number from 0 on is expected.")
    return number


def require_names(**names: object) -> None:
    """See that arguments are names, whose default None would silently take.

    Args:
        names: argument -> what was given for it.

    Raises:
        ConfigurationError: one is no text.
    """
    for argument, name in names.items():
        if not isinstance(name, str):
            raise ConfigurationError(f"{argument} is {name!r}; a name is expected, as text.")


def file_path(argument: str, path: str | Path) -> Path:
    """An argument as a path.

    Raises:
        ConfigurationError: it is none.
    """
    if not isinstance(path, str | os.PathLike):
        raise ConfigurationError(f"{argument} is {path!r}; the path of a file is expected.")
    return Path(path)
