"""Is the robot falling?"""

from __future__ import annotations

import math
from typing import Annotated, Final

import msgspec

from bridge.types import Fraction, NotNegative, Positive, Vec2
from walker.estimation.contact import Contacts


class FallParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the robot counts as falling, and what then."""

    angle: Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)] = math.radians(30.0)
    """Fused torso roll or pitch, rad. With the mass 0.23 m above a sole that ends 0.10 m ahead and 0.05 m
    behind, no ankle brings a NAO back from 24 degrees; the rest is for the error of the fused angle."""
    no_support: Positive = 0.5
    """Time in the walk for which no foot touches, s: lifted, or lying on its back with the legs in the air."""
    lean: Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)] = 0.33
    """rad; the same bound as `angle` of a robot that protects itself. Undisturbed walks reach 0.16."""
    capture: Positive = 0.45
    """rad; the torso's capture angle, its angle and its rate over the frequency of a pendulum as high as the
    mass, beyond which a robot that protects itself counts as falling. Undisturbed walks reach 0.35."""
    capture_cycles: Annotated[int, msgspec.Meta(ge=1, le=100)] = 3
    """Frames in a row for which it has to be."""
    brace_time: NotNegative = 0.4
    """s in which a robot that protects itself goes into its pose, with `brace_stiffness`."""
    brace_stiffness: Fraction = 0.4
    stiffness: Fraction = 0.1
    """Stiffness while falling and lying: the gears give way, the limbs do not flap."""


FREQUENCY: Final = math.sqrt(9.81 / 0.25)
"""rad/s; of a pendulum as high as a NAO's mass over its soles."""


class FallDetector:
    """A fall is a torso that leans too far, or a walk without ground under it for too long.

    A robot that protects itself foresees it. An inverted pendulum at the angle a that turns at the rate w comes
    to rest upright only where its capture angle a + w / frequency is 0; feet make up for a little more.

    Args:
        parameters: the bounds.
        foresees: also the capture angle counts. What the robot would have caught is a fall then.
    """

    def __init__(self, parameters: FallParameters, *, foresees: bool = False) -> None:
        self._p, self._foresees = parameters, foresees
        self._unsupported = 0.0
        self._beyond = 0

    def update(self, angle: Vec2, rate: Vec2, contacts: Contacts, dt: float, *, walking: bool) -> bool:
        """One cycle.

        Args:
            angle: fused torso roll and pitch, rad.
            rate: gyroscope about x and y, rad/s.
            contacts: of the feet.
            dt: time since the last frame, s.
            walking: whether the feet are meant to bear the robot; a robot that hangs in a stand is not falling.

        Returns:
            Whether it falls.
        """
        self._unsupported = self._unsupported + dt if walking and contacts.none else 0.0
        capture = max(abs(a + w / FREQUENCY) for a, w in zip(angle, rate, strict=True))
        self._beyond = self._beyond + 1 if capture > self._p.capture else 0
        foreseen = self._foresees and self._beyond >= self._p.capture_cycles
        leans = max(map(abs, angle)) > (self._p.lean if self._foresees else self._p.angle)
        return foreseen or leans or self._unsupported > self._p.no_support
