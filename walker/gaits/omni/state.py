"""State of the omnidirectional gait, and the constants of its steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from bridge.planar import Pose2D
from bridge.types import Side, Vec2, Vec3
from walker.gaits.omni.parameters import OmniParameters
from walker.gaits.plan import OTHER_SIDE, Phase

REST: Final[Vec3] = (0.0, 0.0, 0.0)
"""No velocity, m/s, m/s, rad/s."""

Kind = Literal["walk", "closing", "ahead", "back"]
"""Kind of a step: of the walk; the last one, which brings the feet side by side; a capture step ahead or back,
which follows the measured capture point."""


class OmniState(NamedTuple):
    """State of the gait, in the walk frame, m and s."""

    stance: Pose2D
    """Pose of the stance foot, or of the first one."""
    liftoff_pose: Pose2D
    """Pose of the other foot before its swing."""
    swing: Side
    """The other foot."""
    target: Pose2D
    """Pose2D at the end of the swing under way."""
    com: Vec2
    xi: Vec2
    """Capture point."""
    zmp: Vec2
    """At rest in `start` and `stop`; in a step, that of the step before."""
    velocity: Vec3 = REST
    """Velocity of the step under way, m/s, m/s, rad/s."""
    correction: Vec3 = REST
    """Added by feedback."""
    heading_correction: float = 0.0
    """Angle by which feedback turned the walk since its beginning, rad."""
    phase: Phase = "stand"
    t: float = 0.0
    """Since the beginning of the phase."""
    step: int = 0
    kind: Kind = "walk"
    """Kind of the step under way, or of the last one until the robot stands."""
    adjustment: Vec2 = (0.0, 0.0)
    """Shift of the target by feedback, m."""
    com_offset: Vec2 = (0.0, 0.0)
    """Planned centre of mass less the pendulum's, m."""
    moved: Vec2 = (0.0, 0.0)
    """Shift of the pendulum by feedback since the beginning, m."""

    @property
    def single(self) -> bool:
        """A step is under way."""
        return self.phase in ("SSL", "SSR")

    @property
    def captures(self) -> bool:
        """The step under way, or the last one, is a capture step."""
        return self.kind in ("ahead", "back")

    @property
    def support(self) -> Side:
        """Side of the stance foot."""
        return OTHER_SIDE[self.swing]

    @property
    def corrected_velocity(self) -> Vec3:
        """Velocity of the step under way with its correction, m/s, m/s, rad/s."""
        x, y, turn = (v + c for v, c in zip(self.velocity, self.correction, strict=True))
        return x, y, turn


@dataclass(frozen=True, eq=False)
class Constants:
    """Parameters, and what follows from them and the body."""

    p: OmniParameters
    omega: float
    """Natural frequency of the pendulum, 1/s."""
    rho: float
    """See `transfer_weight`."""
    heel: float
    """Ends of the left sole from below the ankle: behind, ahead, and to the left, m."""
    toe: float
    outer: float
    hip_height: float
    """m above the ground."""
