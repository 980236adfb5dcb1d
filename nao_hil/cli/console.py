"""The terminal of a command: console, log, JSON, and a note on an unusual engine."""

from __future__ import annotations

import json
import logging
import os
import queue
import shutil
import sys
from collections.abc import Callable
from logging.handlers import QueueHandler, QueueListener
from pathlib import Path
from typing import Any, Final, NamedTuple

import msgspec
from rich.console import Console
from rich.logging import RichHandler
from rich.table import Table
from rich.text import Text

from bridge.errors import NaoHilError
from nao_hil.runs.config import RunConfig

_CONTROL: Final = {
    code: f"\\x{code:02x}" for code in (*range(0x20), *range(0x7F, 0xA0)) if chr(code) not in "\n\t"
}
"""Control characters -> their escapes."""


def printable(text: str) -> str:
    """Text for a terminal: its control characters, which could move the cursor or set the title, as escapes.

    Names, notices and log texts come from other programs on the link.
    """
    return text.translate(_CONTROL)


class _Console(Console):
    """A console that prints no control characters of a text."""

    def render_str(self, text: str, **options: Any) -> Text:
        return super().render_str(printable(text), **options)


class _Formatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return printable(super().format(record))


_listeners: list[QueueListener] = []
WIDE: Final = 1000
"""Columns where there is no terminal: a sentence stays in one line there, for `grep` and for logs."""


def log_to_stderr() -> None:
    """Let the program's own messages go to stderr, with their times; a line each where there is no terminal.

    They are written by a thread of their own: a terminal that is stopped, or a reader that does not read, must
    not hold up a robot's cycle.
    """
    handler: logging.Handler
    if sys.stderr is not None and sys.stderr.isatty():
        handler = RichHandler(console=Console(stderr=True), show_path=False)
        handler.setFormatter(_Formatter("%(message)s"))
    else:
        handler = logging.StreamHandler()
        handler.setFormatter(_Formatter("%(asctime)s %(levelname)s %(message)s"))
    messages: queue.SimpleQueue[logging.LogRecord] = queue.SimpleQueue()
    logging.basicConfig(level=logging.INFO, format="%(message)s", handlers=[QueueHandler(messages)])
    _listeners.append(QueueListener(messages, handler))
    _listeners[-1].start()


def end_log() -> None:
    """Write the text so far, and nothing after that."""
    while _listeners:
        _listeners.pop().stop()


def open_console(*, stderr: bool = True) -> Console:
    """A console on stderr or stdout: as wide as the terminal or `COLUMNS` says, or wide in a pipe or a file.

    Text is printed as it is: the `:CD:` of a fingerprint is no emoji, `[a]` in a path no markup, a number not
    coloured.
    """
    stream = sys.stderr if stderr else sys.stdout
    terminal = stream is not None and stream.isatty()
    width = None if terminal or os.environ.get("COLUMNS") else WIDE
    return _Console(stderr=stderr, width=width, emoji=False, markup=False, highlight=False)


def own_command() -> str:
    """How to call `nao-hil` here: by its path where no environment is active that has it."""
    if shutil.which("nao-hil"):
        return "nao-hil"
    path = Path(sys.executable).with_name("nao-hil")
    return os.path.relpath(path) if path.exists() else f"{sys.executable} -m nao_hil.cli"


def chosen_engine(settings: RunConfig) -> RunConfig:
    """The configuration with its engine by name; a missing PyBullet is reported in a sentence.

    Raises:
        ConfigurationError: the engine is not installed.
    """
    # imported late: the walker's machine has no physics engine
    from emulator.engine.catalogue import ENGINES, WITHOUT_PYBULLET, require_engine
    from nao_hil.runs.build import with_engine

    chosen = with_engine(settings)
    require_engine(chosen.engine)
    if settings.engine == "auto" and chosen.engine != next(iter(ENGINES)):
        open_console().print(WITHOUT_PYBULLET)
    return chosen


class Answer(NamedTuple):
    """Value of a command: one JSON object with `--json`, else text."""

    data: Any
    """For `--json`; None: there is none."""
    show: Table | str | Callable[[], object] = ""
    """Without `--json`: a table or a line for stdout, or a function that prints."""
    code: int = 0
    """Exit code."""
    error: NaoHilError | None = None
    """Raised after the value is printed."""

    def give(self, *, as_json: bool) -> int:
        """Print it; gives the exit code.

        Raises:
            NaoHilError: the one that it has.
        """
        if as_json:
            if self.data is not None:
                print_json(self.data)
        elif callable(self.show):
            self.show()
        elif isinstance(self.show, Table):
            open_console(stderr=False).print(self.show)
        elif self.show:
            print(printable(self.show), flush=True)
        if self.error is not None:
            raise self.error
        return self.code


def print_json(value: Any) -> None:
    """Print the value of a command as one JSON object on the last line of stdout; NaN and infinity are null."""
    plain = msgspec.json.decode(msgspec.json.encode(value, enc_hook=_plain))
    print(json.dumps(plain), flush=True)


def _plain(value: Any) -> Any:
    """A NumPy number as Python's; anything else as text."""
    return value.item() if hasattr(value, "item") else str(value)
