"""What a walker is told to do."""

from __future__ import annotations

import math

import msgspec

from bridge.errors import ConfigurationError
from bridge.types import Vec3
from walker.planning.parameters import GaitParameters


class WalkOrder(msgspec.Struct, frozen=True, kw_only=True):
    """How far to walk: by steps, by time, to a place, or without end."""

    steps: int = 0
    """Steps to walk, the closing step included; 0: no bound. At least 2 when bounded."""
    duration: float = math.inf
    """s of walking after which the robot closes its feet and stands."""
    target: Vec3 | None = None
    """Where to walk, from the middle between the feet at the beginning: forward and to the left, m, and turn,
    rad. For gaits that have `limits`; by the odometry."""
    share: float = 1.0
    """Of the gait's limits that is made use of on the way to the target."""
    settle: float = 1.0
    """s to stand before the order counts as done."""

    @property
    def bounded(self) -> bool:
        """Whether the walk ends after some steps or some time."""
        return self.steps > 0 or math.isfinite(self.duration)


def target_order(order: WalkOrder, target: Vec3, parameters: GaitParameters) -> WalkOrder:
    """The order with a target, as fast as the velocity of the gait's parameters in parts of its limits.

    Args:
        order: Its bounds.
        target: As in `WalkOrder`.
        parameters: Of the gait.

    Raises:
        ConfigurationError: the gait walks straight ahead only, or the turn is beyond half a turn.
    """
    if parameters.limits is None:
        raise ConfigurationError("This gait walks straight ahead, to no target; `omni` walks to any.")
    if abs(target[2]) > math.pi + 1e-6:
        raise ConfigurationError(
            f"The turn of a target is {target[2]:g} rad; it takes -3.14 to 3.14 (90 degrees are 1.57)."
        )
    return msgspec.structs.replace(order, target=target, share=parameters.limits.share(parameters.velocity))
