"""Messages of the guard: its state, the emergency stop, arming, and the lease, which says who may command."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from bridge.messages.frames import SCHEMA_VERSION, Name
from bridge.types import Count

State = Literal["idle", "approach", "active", "hold", "crouch", "sit", "rest", "fallen"]
"""`idle`: nothing has come yet, the joints are left alone; `approach`: slowly on the way to a first command;
`active`: commands are in force; `hold`: the controller is silent, the joints hold; `crouch`: the guard brings
the robot down; `sit`: it sits down from the crouch, and takes no command; `rest`: down, stiffness gone;
`fallen`: limp, no command is taken for a while."""

Reason = Literal["", "silence", "stop", "fall", "temperature", "battery"]
"""Why the guard took over; empty: it did not."""

Text = Annotated[str, msgspec.Meta(max_length=200)]


class GuardStatus(msgspec.Struct, frozen=True, kw_only=True):
    """State of the robot by its own report: published (key `guard`); reply of `guard`, `stop` and `arm`."""

    version: int = SCHEMA_VERSION
    seq: Count
    """Sensor frame since which it is so."""
    state: State
    reason: Reason = ""
    armed: bool
    """False: no command is taken until `arm`."""
    dry_run: bool = False
    """Nothing reaches the motors."""
    holder: str = ""
    """Name of the controller that holds the robot; empty: it is free."""
    text: str
    """One sentence."""

    @property
    def under_command(self) -> bool:
        """A controller's commands are in force."""
        return self.state in ("approach", "active")


class StopRequest(msgspec.Struct, frozen=True, kw_only=True):
    """Emergency stop; needs no lease, anyone may send it."""

    version: int = SCHEMA_VERSION
    how: Literal["crouch", "limp"] = "crouch"
    """`crouch`: go down at limited speed, then let go; `limp`: let go at once, a robot that stands falls."""
    who: Text = ""
    """Said in the notice."""


class ArmRequest(msgspec.Struct, frozen=True, kw_only=True):
    """Commands may be taken from now on; needs no lease."""

    version: int = SCHEMA_VERSION
    who: Text = ""


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
    """Name of the controller that holds the lease now; empty when none does."""
    message: str
