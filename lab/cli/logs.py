"""What a command says while it runs."""

from __future__ import annotations

import logging
import sys

from rich.console import Console
from rich.logging import RichHandler


def log_to_stderr() -> None:
    """Let the program's own messages go to stderr, with their times; a line each where there is no terminal."""
    if sys.stderr is not None and sys.stderr.isatty():
        rich = RichHandler(console=Console(stderr=True), show_path=False)
        logging.basicConfig(level=logging.INFO, format="%(message)s", handlers=[rich])
    else:
        logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s")
