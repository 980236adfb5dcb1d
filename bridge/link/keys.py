"""Key expressions of the contract: everything of a robot is under `nao/<robot>/`."""

from __future__ import annotations

import re
from typing import Final

from bridge.errors import ConfigurationError
from bridge.messages.frames import NAME

DEFAULT_ROBOT: Final = "nao"
DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"
"""Loopback: by default nothing listens beyond this machine."""

SENSORS: Final = "sensors"
ACTUATORS: Final = "actuators"
LEDS: Final = "leds"
INFO: Final = "info"
LEASE: Final = "lease"
NOTICES: Final = "notices"
GUARD: Final = "guard"
STOP: Final = "stop"
ARM: Final = "arm"
TRUTH: Final = "world/truth"
TELEMETRY: Final = "walk/telemetry"
UPPER_BODY: Final = "walk/upper-body"
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


def alive_controller(name: str, ticket: int) -> str:
    """Suffix of a controller's liveliness token; the ticket distinguishes two of the same name."""
    return f"alive/controller/{name}.{ticket:016x}"
