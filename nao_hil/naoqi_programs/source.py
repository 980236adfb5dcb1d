"""Whether a program is Python 3, and what to do when it is not."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from bridge.errors import ConfigurationError

_OLD: Final = (
    re.compile(r"^\s*print\s+[^(\s=]", re.MULTILINE),
    re.compile(r"^\s*print\s*$", re.MULTILINE),
    re.compile(r"^\s*except\s+[\w.()\s,]+,\s*\w+\s*:", re.MULTILINE),
    re.compile(r"^\s*raise\s+\w+\s*,", re.MULTILINE),
    re.compile(r"^\s*exec\s+[\"'\w]", re.MULTILINE),
    re.compile(r"<>"),
    re.compile(r"\bur['\"]"),
    re.compile(r"[=(,\s]0[0-7]+\b"),
)
"""What Python 3 no longer reads."""


def require_python3(path: Path) -> None:
    """See that a program can be run.

    Raises:
        ConfigurationError: it cannot be read, it is Python 2, or no Python at all; says what would help.
    """
    try:
        text = path.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise ConfigurationError(f"{path} cannot be read ({reason}).") from None
    try:
        compile(text, str(path), "exec")
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None) or 0
        source = text.decode("utf-8", "replace")
        if any(pattern.search(source) for pattern in _OLD) or isinstance(error, TabError):
            raise ConfigurationError(
                f"{path} is written for Python 2 (line {line}); convert it first, with `2to3 -w {path.name}` "
                "of Python 3.12 or older, and run it again."
            ) from None
        raise ConfigurationError(
            f"{path}, line {line}: {getattr(error, 'msg', str(error))}; this is no Python program."
        ) from None
