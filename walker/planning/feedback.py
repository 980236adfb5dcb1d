"""What the sensors tell a gait that can change its footholds in stride."""

from __future__ import annotations

from typing import NamedTuple

from bridge.types import Vec2
from walker.planning.plan import Foothold


class Feedback(NamedTuple):
    """Measured, in the frame of the plan."""

    deviation: Vec2 = (0.0, 0.0)
    """Capture point of the robot less that of the plan when this cycle's command is carried out, m."""
    placement: float = 0.0
    """Way by which the feet come down behind their footholds, along the heading of the stance foot, m."""

    def turned(self, yaw: float) -> Feedback:
        """The same in a frame in which this one's x axis has the direction `yaw`, rad."""
        return Feedback(Foothold(yaw=yaw).point(*self.deviation), self.placement)


NONE = Feedback()
"""As if no sensor were there."""
