"""What the parameters of all gaits have in common: the length and the duration of a step, and the velocity."""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple, TypeVar

import msgspec

from bridge.errors import ConfigurationError
from bridge.types import Vec3
from walker.planning.steering import Limits

P = TypeVar("P", bound="GaitParameters")


class PeriodicStep(NamedTuple):
    """The step that a gait repeats."""

    length: float
    """From one foothold to the next, m."""
    duration: float
    """s"""

    @property
    def velocity(self) -> float:
        """Mean, m/s."""
        return self.length / self.duration


class GaitParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of the parameters of every gait."""

    LENGTH: ClassVar[str | None] = None
    """Name of the parameter to which the length of a step is proportional; None: the length is fixed."""

    @property
    def periodic_step(self) -> PeriodicStep:
        """The step that these parameters mean."""
        raise NotImplementedError

    @property
    def limits(self) -> Limits | None:
        """Of the velocity, where the gait walks backward and sideways and turns, too; None: straight only."""
        return None

    @property
    def velocity(self) -> Vec3:
        """Mean velocity, forward and to the left, m/s, and turn, rad/s."""
        return self.periodic_step.velocity, 0.0, 0.0

    def with_velocity(self: P, velocity: Vec3) -> P:
        """The parameters with steps of the length that makes a mean velocity; the phases keep their times.

        Whether the body can walk them is for the gait and `walker.planning.walkable` to say.

        Args:
            velocity: forward and to the left, m/s, and turn, rad/s.

        Raises:
            ConfigurationError: the length of the steps is fixed, or the gait does not go that way.
        """
        x, y, turn = velocity
        if x <= 0.0 or y != 0.0 or turn != 0.0:
            raise ConfigurationError(
                f"This gait walks straight ahead: vx must be positive, vy and omega 0, not {x:g} m/s, "
                f"{y:g} m/s and {turn:g} rad/s; `omni` goes in any direction."
            )
        if self.LENGTH is None:
            raise ConfigurationError("The steps of this gait have a fixed length; leave the velocity out.")
        value = getattr(self, self.LENGTH) * x / self.periodic_step.velocity
        return msgspec.structs.replace(self, **{self.LENGTH: value})


def clipped_in_words(wanted: Vec3, walked: Vec3) -> str:
    """What a velocity lost to the limits of a gait, in words; empty: nothing.

    Args:
        wanted: Forward and to the left, m/s, and turn, rad/s.
        walked: What is walked of it.
    """
    if math.dist(wanted, walked) < 1e-9:
        return ""
    x, y, turn = wanted
    return f"{x:g} m/s, {y:g} m/s and {turn:g} rad/s are beyond the gait's limits and were scaled down together"
