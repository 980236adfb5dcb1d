"""Ctrl-C, SIGTERM and the death of the command that started this one end a command in good order."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from nao_hil.runs.supervisor import SUPERVISED


def on_signals(stop: Callable[[], None]) -> None:
    """Call `stop` at the first Ctrl-C or SIGTERM; a second one ends the process at once.

    A thread of its own calls it. Python runs a handler in the main thread, between two lines: to set a
    `threading.Event` there that the main thread begins to wait for would wait for ever, and a signal that comes
    while the main thread goes to sleep on a lock does not run its handler at all. The number that Python
    writes to the wakeup descriptor arrives in either case.

    A child of `nao-hil up` takes the end of its stdin, which a killed parent leaves behind, for a Ctrl-C.
    """
    reading, writing = os.pipe()
    os.set_blocking(writing, False)

    def handle(number: int, _frame: object) -> None:
        signal.signal(number, signal.SIG_DFL)

    def await_signal() -> None:
        os.read(reading, 1)
        stop()

    threading.Thread(target=await_signal, name="signals", daemon=True).start()

    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    signal.signal(signal.SIGINT, handle)
    signal.signal(signal.SIGTERM, handle)
    if SUPERVISED in os.environ:
        threading.Thread(target=_interrupt_at_end_of_stdin, name="supervised", daemon=True).start()


def stop_event(wake: Callable[[], object] = lambda: None) -> threading.Event:
    """An event that the first Ctrl-C or SIGTERM sets, as in `on_signals`; then `wake` is called."""
    stop = threading.Event()

    def end() -> None:
        stop.set()
        wake()

    on_signals(end)
    return stop


def _interrupt_at_end_of_stdin() -> None:
    sys.stdin.buffer.read()
    os.kill(os.getpid(), signal.SIGINT)


@contextmanager
def loading(after: Any = None) -> Iterator[None]:
    """While this lasts, a Ctrl-C ends the process at once, with the exit code of an interruption.

    A `KeyboardInterrupt` can get lost in an import: Python ignores it in a destructor or in a weak reference's
    callback, and the process continues.

    Args:
        after: Handler from then on; None: the present one.
    """
    before = signal.signal(signal.SIGINT, lambda _number, _frame: os._exit(130))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before if after is None else after)
