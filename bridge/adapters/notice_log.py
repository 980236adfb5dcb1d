"""A robot's notices in the log of whoever serves it."""

from __future__ import annotations

import logging
from typing import Final

from bridge.messages import Notice

_LEVELS: Final = {"info": logging.INFO, "error": logging.ERROR}


def log_notice(logger: logging.Logger, notice: Notice) -> None:
    """Log a notice at its own level; clipped angles, which may come in each cycle, only for debugging.

    Args:
        logger: of the server.
        notice: from the robot.
    """
    level = logging.DEBUG if notice.code == "clipped" else _LEVELS.get(notice.level, logging.WARNING)
    logger.log(level, "the robot says: %s", notice.text)
