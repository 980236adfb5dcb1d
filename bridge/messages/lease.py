"""The lease: which controller may command the robot (query `lease`)."""

from __future__ import annotations

from typing import Literal

import msgspec

from bridge.messages.schema import SCHEMA_VERSION, Name
from bridge.types import Count


class LeaseRequest(msgspec.Struct, frozen=True, kw_only=True):
    """Ask for, give back, or look at the lease (query `lease`)."""

    version: int = SCHEMA_VERSION
    op: Literal["acquire", "release", "status"]
    controller: Name
    """Name of the controller, also in its liveliness token."""
    ticket: Count = 0
    """Number that the controller drew at its start, also in its liveliness token, in hexadecimal: it tells two
    controllers of the same name apart."""
    direct: bool = False
    """The controller serves another robot's protocol (LoLA, NAOqi): an emulated robot takes its commands as
    that robot does, without an approach, a limit of the speed or a reaction to falls. A real one ignores it."""


class LeaseReply(msgspec.Struct, frozen=True, kw_only=True):
    """Answer to a `LeaseRequest`."""

    version: int = SCHEMA_VERSION
    granted: bool
    lease: Count
    """The number to put into each actuator frame; 0 unless granted."""
    holder: str
    """Name of the controller that holds the lease now; empty when nobody does."""
    message: str
