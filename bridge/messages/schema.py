"""The schema version, the largest payload, and the form of names: common to all messages."""

from __future__ import annotations

from typing import Annotated, Final, Protocol

import msgspec

SCHEMA_VERSION: Final = 2
"""Version of every message; a receiver refuses a version it does not know."""

MAX_PAYLOAD: Final = 65536
"""bytes; a receiver does not look into anything longer."""

NAME: Final = r"^[A-Za-z0-9_-]{1,64}(?!\n)$"
"""Ids of robots, names of controllers and of boxes."""

Name = Annotated[str, msgspec.Meta(pattern=NAME)]


class Versioned(Protocol):
    """Any message."""

    @property
    def version(self) -> int:
        """Schema version it was written in."""
