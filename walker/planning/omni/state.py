"""What the omnidirectional gait knows from one cycle to the next."""

from __future__ import annotations

from typing import Final, NamedTuple

from bridge.types import Side, Vec2, Vec3
from walker.planning.plan import Foothold, Phase

REST: Final[Vec3] = (0.0, 0.0, 0.0)
"""No velocity, m/s, m/s, rad/s."""


class OmniState(NamedTuple):
    """Where the gait is, in the walk frame, m and s."""

    stance: Foothold
    """Of the foot that stands, or stands first."""
    lifted: Foothold
    """Of the other foot before its swing."""
    swing: Side
    """The other foot."""
    target: Foothold
    """Where the swing under way ends."""
    com: Vec2
    xi: Vec2
    """Capture point."""
    zmp: Vec2
    """At rest in `start` and `stop`; in a step, that of the step before."""
    velocity: Vec3 = REST
    """Of the step under way, m/s, m/s, rad/s."""
    correction: Vec3 = REST
    """What feedback adds to it."""
    turned: float = 0.0
    """Angle by which feedback turned the walk since its beginning, rad."""
    phase: Phase = "stand"
    t: float = 0.0
    """Since the beginning of the phase."""
    step: int = 0
    closing: bool = False
    """The step under way brings the feet side by side."""
    capture_step: bool = False
    """The step under way, or the last one, is a capture step: it follows the measured capture point."""
    backward: bool = False
    """That capture step goes back."""
    adjustment: Vec2 = (0.0, 0.0)
    """By which feedback moved the target, m."""
    behind: Vec2 = (0.0, 0.0)
    """Planned centre of mass less the pendulum's, m."""
    moved: Vec2 = (0.0, 0.0)
    """Way by which the pendulum was put elsewhere since the beginning, m."""

    @property
    def single(self) -> bool:
        """A step is under way."""
        return self.phase in ("SSL", "SSR")

    @property
    def corrected_velocity(self) -> Vec3:
        """Of the step under way with its correction, m/s, m/s, rad/s."""
        x, y, turn = (v + c for v, c in zip(self.velocity, self.correction, strict=True))
        return x, y, turn
