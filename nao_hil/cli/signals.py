"""Ctrl-C, SIGTERM and the death of the command that started this one end a command in good order."""

from __future__ import annotations

import os
import queue
import signal
import sys
import threading
from collections.abc import Callable

from nao_hil.runs.supervisor import SUPERVISED


def on_signals(stop: Callable[[], None]) -> None:
    """Call `stop` at the first Ctrl-C or SIGTERM; a second one ends the process at once.

    It is called in a thread of its own: a handler runs between two lines of whatever the main thread does, and
    to set a `threading.Event` there that the main thread begins to wait for would wait for ever.

    A child of `nao-hil up` takes the end of its stdin, which a killed parent leaves behind, for a Ctrl-C.
    """
    came: queue.SimpleQueue[int] = queue.SimpleQueue()

    def handle(number: int, _frame: object) -> None:
        signal.signal(number, signal.SIG_DFL)
        came.put(number)

    def await_signal() -> None:
        came.get()
        stop()

    threading.Thread(target=await_signal, name="signals", daemon=True).start()

    signal.signal(signal.SIGINT, handle)
    signal.signal(signal.SIGTERM, handle)
    if SUPERVISED in os.environ:
        threading.Thread(target=_interrupt_at_end_of_stdin, name="supervised", daemon=True).start()


def stop_event() -> threading.Event:
    """An event that the first Ctrl-C or SIGTERM sets, as in `on_signals`."""
    stop = threading.Event()
    on_signals(stop.set)
    return stop


def _interrupt_at_end_of_stdin() -> None:
    sys.stdin.buffer.read()
    os.kill(os.getpid(), signal.SIGINT)
