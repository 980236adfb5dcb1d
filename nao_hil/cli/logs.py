"""What a command says while it runs."""

from __future__ import annotations

import logging
import queue
import sys
from logging.handlers import QueueHandler, QueueListener

from rich.console import Console
from rich.logging import RichHandler

_listeners: list[QueueListener] = []


def log_to_stderr() -> None:
    """Let the program's own messages go to stderr, with their times; a line each where there is no terminal.

    They are written by a thread of their own: a terminal that is stopped, or a reader that does not read, must
    not hold up a robot's cycle.
    """
    handler: logging.Handler
    if sys.stderr is not None and sys.stderr.isatty():
        handler = RichHandler(console=Console(stderr=True), show_path=False)
        handler.setFormatter(logging.Formatter("%(message)s"))
    else:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    messages: queue.SimpleQueue[logging.LogRecord] = queue.SimpleQueue()
    logging.basicConfig(level=logging.INFO, format="%(message)s", handlers=[QueueHandler(messages)])
    _listeners.append(QueueListener(messages, handler))
    _listeners[-1].start()


def end_log() -> None:
    """Write what has been said so far; nothing is written after that."""
    while _listeners:
        _listeners.pop().stop()
