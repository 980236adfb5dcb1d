"""ALNotificationManager: what programs tell the user, kept until it is removed."""

from __future__ import annotations

import itertools
import logging
from typing import Any, Final

from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused

logger = logging.getLogger(__name__)

_MOST: Final = 100
"""Notifications that are kept; the oldest goes."""


class Notifications:
    """Methods of the service; not thread-safe, the caller locks."""

    def __init__(self) -> None:
        self._numbers = itertools.count(1)
        self._kept: dict[int, dict[str, Any]] = {}

    def add(self, notification: Any) -> int:
        """Tell something: a `message`, a `severity` and whether to `removeOnRead`; its number."""
        if not isinstance(notification, dict) or not isinstance(notification.get("message"), str):
            raise NaoqiRefused(
                f"ALNotificationManager.add: {notification!r:.40} was given; a map with `message` is expected."
            )
        number = next(self._numbers)
        self._kept[number] = {**notification, "id": number}
        if len(self._kept) > _MOST:
            del self._kept[min(self._kept)]
        logger.info("notification: %.500s", notification["message"])
        return number

    def get(self, number: Any) -> dict[str, Any]:
        """A notification; those with `removeOnRead` are removed.

        Raises:
            NaoqiRefused: there is none of this number.
        """
        if number not in list(self._kept):
            raise NaoqiRefused(f"ALNotificationManager: there is no notification {number!r:.40}.")
        found = self._kept[number]
        if found.get("removeOnRead"):
            del self._kept[number]
        return found

    def methods(self) -> Table:
        """Methods of the service."""
        return {
            "add": self.add,
            "notification": self.get,
            "notifications": lambda: list(self._kept.values()),
            "remove": lambda number: self._kept.pop(number, None) and None,
        }
