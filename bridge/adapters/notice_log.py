"""A robot's notices in the log of whoever serves it, and that log's warnings as notices."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Final

from bridge.messages import Notice

SERVER: Final = "server"
"""Code of notices that are warnings of a server's log."""
_LEVELS: Final = {"info": logging.INFO, "error": logging.ERROR}


def log_notice(logger: logging.Logger, notice: Notice) -> None:
    """Log a notice at its own level; clipped angles, which may come in each cycle, only for debugging.

    Args:
        logger: of the server.
        notice: from the robot.
    """
    if notice.code == SERVER:
        return
    level = logging.DEBUG if notice.code == "clipped" else _LEVELS.get(notice.level, logging.WARNING)
    logger.log(level, _SAYS, notice.text)


_SAYS: Final = "the robot says: %s"


class NoticeHandler(logging.Handler):
    """Publishes the warnings of a server, for the page and other listeners.

    Args:
        publish: one notice.
    """

    def __init__(self, publish: Callable[[Notice], None]) -> None:
        super().__init__(logging.WARNING)
        self._publish = publish

    def emit(self, record: logging.LogRecord) -> None:
        """Publish a warning that is not itself a notice."""
        if record.msg != _SAYS:
            self._publish(Notice(seq=0, level="warning", code=SERVER, text=record.getMessage()))
