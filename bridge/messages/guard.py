"""Messages of the guard: its state, the emergency stop, arming, and the lease, the right to command."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from bridge.messages.frames import SCHEMA_VERSION, Name
from bridge.types import Count, Finite

State = Literal["idle", "approach", "active", "hold", "crouch", "sit", "rest", "fallen"]
"""`idle`: no command yet, the joints are left alone; `approach`: slowly on the way to a first command;
`active`: commands are in force; `hold`: the controller is silent, the joints hold; `crouch`: the guard brings
the robot down; `sit`: it sits down from the crouch, and takes no command; `rest`: down, without stiffness;
`fallen`: limp, no command is taken for a while."""

Reason = Literal["", "silence", "stop", "fall", "temperature", "battery", "sensors"]
"""Reason for which the guard controls the joints; empty: it does not."""

Text = Annotated[str, msgspec.Meta(max_length=200)]

PublicKey = Annotated[str, msgspec.Meta(pattern=r"^([0-9a-f]{64})?(?!\n)$")]
"""X25519 key (RFC 7748) in hexadecimal; empty: none."""


class GuardStatus(msgspec.Struct, frozen=True, kw_only=True):
    """State of the robot by its own report: published (key `guard`); reply of `guard`, `stop` and `arm`."""

    version: int = SCHEMA_VERSION
    seq: Count
    """First sensor frame of this state."""
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
    position: tuple[Finite, ...] = ()
    """Only in replies: 25 joint angles commanded last, rad; empty: the joints have been left alone. A first
    command that the robot already holds; measured angles are lower, by the sag of the joints under load."""

    @property
    def under_command(self) -> bool:
        """A controller's commands are in force."""
        return self.state in ("approach", "active")


class StopRequest(msgspec.Struct, frozen=True, kw_only=True):
    """Emergency stop; needs no lease, anyone may send it."""

    version: int = SCHEMA_VERSION
    how: Literal["crouch", "limp"] = "crouch"
    """`crouch`: crouch at limited speed, then release the joints; `limp`: release them at once."""
    who: Text = ""
    """Sender, for the notice."""


class ArmRequest(msgspec.Struct, frozen=True, kw_only=True):
    """Permission to take commands from now on; needs no lease."""

    version: int = SCHEMA_VERSION
    who: Text = ""


class LeaseRequest(msgspec.Struct, frozen=True, kw_only=True):
    """Ask for, give back, or look at the lease (query `lease`)."""

    version: int = SCHEMA_VERSION
    op: Literal["acquire", "release", "status"]
    controller: Name
    """Name of the controller, also in its liveliness token."""
    key: PublicKey = ""
    """The controller's, also in its liveliness token: it distinguishes two controllers of the same name."""
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
    key: PublicKey = ""
    """The robot's, of this start; empty: it gives no lease."""
