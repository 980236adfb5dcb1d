"""The console that commands write to."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from typing import Final

from rich.console import Console

WIDE: Final = 1000
"""Columns where there is no terminal: a sentence stays in one line there, for `grep` and for logs."""


def open_console(*, stderr: bool = True) -> Console:
    """A console on stderr or stdout: as wide as the terminal or `COLUMNS` says, or wide in a pipe or a file.

    What it prints stays as it is: the `:CD:` of a fingerprint is no emoji, `[a]` in a path no markup.
    """
    stream = sys.stderr if stderr else sys.stdout
    terminal = stream is not None and stream.isatty()
    width = None if terminal or os.environ.get("COLUMNS") else WIDE
    return Console(stderr=stderr, width=width, emoji=False, markup=False)


def own_command() -> str:
    """How to call `nao-hil` here: by its path where no environment is active that has it."""
    if shutil.which("nao-hil"):
        return "nao-hil"
    path = Path(sys.executable).with_name("nao-hil")
    return os.path.relpath(path) if path.exists() else f"{sys.executable} -m nao_hil.cli"
