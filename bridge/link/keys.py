"""Key expressions of the contract: everything of a robot is under `nao/<robot>/`.

The keys of published messages are in `bridge.messages.topics`; those of queries and tokens here.
"""

from __future__ import annotations

import re
from typing import Any, Final

from bridge.errors import ConfigurationError
from bridge.messages.frames import NAME
from bridge.messages.topics import TOPICS

DEFAULT_ROBOT: Final = "nao"
DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"
"""Loopback: by default nothing listens beyond this machine."""

INFO: Final = "info"
LEASE: Final = "lease"
GUARD: Final = "guard"
STOP: Final = "stop"
ARM: Final = "arm"
ALIVE_ROBOT: Final = "alive/robot"
ALIVE_CONTROLLERS: Final = "alive/controller/*"

_NAME: Final = re.compile(NAME)


def check_name(kind: str, name: str) -> str:
    """The name, if it can be one part of a key.

    Raises:
        ConfigurationError: empty, too long, or with other characters.
    """
    if not isinstance(name, str) or not _NAME.match(name):
        raise ConfigurationError(f"{kind} {name!r} must be 1 to 64 letters, digits, `_` or `-`.")
    return name


def key(robot: str, suffix: str) -> str:
    """Full key expression of a robot's `suffix`."""
    return f"nao/{robot}/{suffix}"


def topic_key(robot: str, kind: type[Any]) -> str:
    """Full key expression of a robot's messages of a kind of `TOPICS`."""
    return key(robot, TOPICS[kind].suffix)


def alive_controller(name: str, public: str) -> str:
    """Suffix of a controller's liveliness token; its public key distinguishes two of the same name."""
    return f"alive/controller/{name}.{public}"
