"""LogManager: the log of the served robot as libqicore's service tells it to programs."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any, Final

from bridge.adapters.naoqi.qi_connection import MAIN
from bridge.adapters.naoqi.qi_directory import Methods, meta_object
from bridge.adapters.naoqi.qi_values import encode

LOG_MANAGER: Final = "LogManager"
_LEVEL: Final = "(i)<LogLevel,level>"
_TIME: Final = "(L)<TimePoint,ns>"
_MESSAGE: Final = (
    f"(s{_LEVEL}sssI{_TIME}{_TIME})<LogMessage,source,level,category,location,message,id,date,systemDate>"
)
METHODS: Final[Methods] = {
    100: ("log", f"([{_MESSAGE}])", "v"),
    101: ("createListener", "()", "o"),
    102: ("getListener", "()", "o"),
}
LISTENER: Final = MAIN + 1
"""Number of the one listener's object."""
_ON_MESSAGE: Final = 103
LISTENER_META: Final = meta_object(
    {
        100: ("setLevel", f"({_LEVEL})", "v"),
        101: ("setCategory", f"(s{_LEVEL})", "v"),
        102: ("clearFilters", "()", "v"),
    },
    {_ON_MESSAGE: ("onLogMessage", f"({_MESSAGE})")},
)
_LEVELS: Final = {logging.CRITICAL: 1, logging.ERROR: 2, logging.WARNING: 3, logging.INFO: 4, logging.DEBUG: 6}


class LogEvents(logging.Handler):
    """Sends what this process logs as events of the listener; its settings have no effect.

    Args:
        send: an event's object, action and payload, in any thread.
    """

    def __init__(self, send: Callable[[int, int, bytes], None]) -> None:
        super().__init__(logging.INFO)
        self._send = send
        self._number = 0

    def emit(self, record: logging.LogRecord) -> None:
        """See `logging.Handler`."""
        self._number += 1
        source = f"{record.filename}:{record.funcName}:{record.lineno}"
        level = [_LEVELS.get(record.levelno, 4)]
        now: list[Any] = [int(1e9 * record.created)]
        since_start = [time.monotonic_ns()]
        text = record.getMessage()
        message = [source, level, record.name, "nao-hil", text, self._number, since_start, now]
        self._send(LISTENER, _ON_MESSAGE, encode(f"({_MESSAGE})", [message]))
