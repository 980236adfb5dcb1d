"""Is the robot falling?"""

from __future__ import annotations

import math
from typing import Annotated

import msgspec

from bridge.types import Fraction, NotNegative, Positive, Vec2
from walker.estimation.contact import Contacts


class FallParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the robot counts as falling, and what then."""

    angle: Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)] = math.radians(30.0)
    """Fused torso roll or pitch, rad. With the mass 0.23 m above a sole that ends 0.10 m ahead and 0.05 m
    behind, no ankle brings a NAO back from 24 degrees; the rest is for the error of the fused angle."""
    capture_angle: Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)] = math.radians(45.0)
    """The same from the beginning of a capture step until the robot stands: the feet follow the mass."""
    no_support: Positive = 0.5
    """Time in the walk for which no foot touches, s: lifted, or lying on its back with the legs in the air."""
    brace_time: NotNegative = 0.4
    """s in which a robot that protects itself goes into its pose, with `brace_stiffness`."""
    brace_stiffness: Fraction = 0.4
    stiffness: Fraction = 0.1
    """Stiffness while falling and lying: the gears give way, the limbs do not flap."""


class FallDetector:
    """A fall is a torso that leans too far, or a walk without ground under it for too long.

    Args:
        parameters: the bounds.
    """

    def __init__(self, parameters: FallParameters) -> None:
        self._p = parameters
        self._unsupported = 0.0

    def update(
        self, angle: Vec2, contacts: Contacts, dt: float, *, walking: bool, capturing: bool = False
    ) -> bool:
        """One cycle.

        Args:
            angle: fused torso roll and pitch, rad.
            contacts: of the feet.
            dt: time since the last frame, s.
            walking: whether the feet are meant to bear the robot; a robot that hangs in a stand is not falling.
            capturing: whether it makes a capture step, or made one and does not stand yet.

        Returns:
            Whether it falls.
        """
        self._unsupported = self._unsupported + dt if walking and contacts.none else 0.0
        bound = self._p.capture_angle if capturing else self._p.angle
        return max(map(abs, angle)) > bound or self._unsupported > self._p.no_support
