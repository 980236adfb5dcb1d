"""Description of a robot (query `info`), and its notices (key `notices`)."""

from __future__ import annotations

import msgspec

from bridge.messages.frames import SCHEMA_VERSION, Name
from bridge.types import Count, Finite


class Info(msgspec.Struct, frozen=True, kw_only=True):
    """Description of a robot and of its clock (query `info`)."""

    version: int = SCHEMA_VERSION
    robot: Name
    """Robot id: the second part of every key."""
    body: str
    """Data-sheet name, for example `nao-v3`."""
    side: str
    """`emulator`, `lola` or `naoqi`."""
    mode: str
    """`real-time` or `lockstep`."""
    cycle: Finite
    """Cycle time, s."""
    absent: tuple[str, ...]
    """Joints of the frame that this body does not have; their slots are ignored and read 0."""
    boot: Count
    """Number of this start of the robot process; a new number means that the robot restarted."""
    software: str
    limits: tuple[tuple[Finite, Finite], ...] = ()
    """Range of each slot of the frame, rad (hands: 0 to 1); 0, 0 for a joint that the body lacks."""
    actuators: tuple[str, ...] = ()
    """Names that `dcm/createAlias` and `dcm/set` know."""
    stand: tuple[Finite, ...] = ()
    """The published posture StandInit inside these ranges, 25 positions, rad."""
    crouch: tuple[Finite, ...] = ()
    """The published posture Crouch inside these ranges, 25 positions, rad."""


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
