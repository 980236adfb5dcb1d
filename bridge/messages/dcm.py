"""Messages of the `dcm/` queries: NAOqi's low-level module, reached through the contract.

One key for each method. An ALValue of a DCM program is passed as the same list in msgpack
(strings, numbers, lists). `docs/dcm.md` is the specification for other languages.
"""

from __future__ import annotations

from typing import Annotated, Any, Final

import msgspec

from bridge.messages.frames import SCHEMA_VERSION
from bridge.types import Count

CREATE_ALIAS: Final = "dcm/createAlias"
SET: Final = "dcm/set"
SET_ALIAS: Final = "dcm/setAlias"
GET_TIME: Final = "dcm/getTime"
GET_PREFIX: Final = "dcm/getPrefix"
READ: Final = "dcm/read"
PREFERENCES: Final = "dcm/preferences"
SPECIAL: Final = "dcm/special"
CALIBRATION: Final = "dcm/calibration"

COMMANDS: Final = (CREATE_ALIAS, SET, SET_ALIAS)
"""Those that need the lease."""

PREFIX: Final = "Device/SubDeviceList/"
"""Root of all actuator and sensor names; every name may be given with or without it."""


class DcmCommand(msgspec.Struct, frozen=True, kw_only=True):
    """Request of `createAlias`, `set` and `setAlias`; the reply's result is the alias, or None."""

    version: int = SCHEMA_VERSION
    lease: Count
    """Number that the robot gave with the lease."""
    command: list[Any]
    """createAlias: `[alias, [actuator, ...]]`; set: `[name, update, [[value, time], ...]]`; setAlias:
    `[alias, update, "time-separate", 0, [time, ...], [[value, ...], ...]]`,
    `[alias, update, "time-mixed", [[[value, time], ...], ...]]` or `[alias, time, [value, ...]]`."""


class DcmTime(msgspec.Struct, frozen=True, kw_only=True):
    """Request of `getTime`; the reply's result is the DCM's clock plus the offset, ms, a signed 4-byte int."""

    version: int = SCHEMA_VERSION
    offset: Annotated[int, msgspec.Meta(ge=-(2**31), le=2**31 - 1)] = 0
    """Offset that is added to the time, ms."""


class DcmRead(msgspec.Struct, frozen=True, kw_only=True):
    """Request of `read`; the reply's result is one number per name.

    Replaces ALMemory for the DCM's own keys; sensors are in the `sensors` frames.
    """

    version: int = SCHEMA_VERSION
    names: list[str]
    """Keys `.../Actuator/Value`, `/Min`, `/Max`, `/Gain`, `/Offset`, and `DCM/Time`, `DCM/CycleTime`,
    `DCM/TargetCycleTime`."""


class DcmCall(msgspec.Struct, frozen=True, kw_only=True):
    """Request of `getPrefix`, and of the refused methods: `preferences`, `special`, `calibration`."""

    version: int = SCHEMA_VERSION


class DcmReply(msgspec.Struct, frozen=True, kw_only=True):
    """Answer to any of the requests; a refusal is an error reply of one sentence instead."""

    version: int = SCHEMA_VERSION
    result: Any = None
