"""Notices of the robot side (key `notices`)."""

from __future__ import annotations

import msgspec

from bridge.messages.schema import SCHEMA_VERSION
from bridge.types import Count


class Notice(msgspec.Struct, frozen=True, kw_only=True):
    """One sentence from the robot side about something it refused, changed or saw (key `notices`)."""

    version: int = SCHEMA_VERSION
    seq: Count
    level: str
    """`info`, `warning` or `error`."""
    code: str
    """Short stable name, for example `frame-refused`."""
    text: str

    @property
    def routine(self) -> bool:
        """The guard follows a controller that took the robot, or holds for one that gave it back."""
        return self.code == "guard-active" or (self.code == "guard-hold" and self.level == "info")
