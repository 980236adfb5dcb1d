"""Ctrl-C while libraries load."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def loading() -> Iterator[None]:
    """While this lasts, a Ctrl-C ends the process at once, with the exit code of an interruption.

    A `KeyboardInterrupt` can get lost in an import: Python ignores it in a destructor or in a weak reference's
    callback, and the process goes on.
    """
    before = signal.signal(signal.SIGINT, lambda _number, _frame: os._exit(130))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
