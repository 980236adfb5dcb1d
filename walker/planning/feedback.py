"""What the sensors tell a gait that can change its footholds in stride."""

from __future__ import annotations

from typing import NamedTuple

from bridge.types import Vec2
from walker.planning.plan import Foothold


class CaptureStep(NamedTuple):
    """Measured pendulum of a robot that falls unless it makes a capture step."""

    com: Vec2
    """Centre of mass, m."""
    xi: Vec2
    """Capture point, m."""


class LandedFoot(NamedTuple):
    """Measured about the foot that landed from a capture step."""

    xi: float
    """Capture point to the left of its ankle, in its frame, m."""
    roll: float
    """Of the torso when this cycle's command is carried out, rad."""


class Feedback(NamedTuple):
    """Measured, in the frame of the plan."""

    deviation: Vec2 = (0.0, 0.0)
    """Capture point of the robot less that of the plan when this cycle's command is carried out, m."""
    placement: float = 0.0
    """Way by which the feet come down behind their footholds, along the heading of the stance foot, m."""
    heading: float = 0.0
    """Of the robot less that of the plan, since the walk began, rad."""
    velocity: Vec2 = (0.0, 0.0)
    """To add to the command so that the robot walks at the commanded one, forward and to the left, m/s."""
    hold: bool = False
    """The step under way is not to end: the robot stands on the outer edge of its stance foot."""
    tipping: float = 0.0
    """Deviation to the outside of the stance foot, less a part of that along it, m; 0 with both feet."""
    counterweight: float = 0.0
    """Way by which the swing foot goes farther to its side, m."""
    capture_step: CaptureStep | None = None
    """While the robot makes a capture step; when this cycle's command is carried out."""
    landed: LandedFoot | None = None
    """After a capture step, until the feet close."""

    def seen_from(self, origin: Foothold) -> Feedback:
        """The same in the frame of a pose on the ground."""
        deviation = Foothold(yaw=-origin.yaw).point(*self.deviation)
        measured = self.capture_step and CaptureStep(*(origin.local(*each) for each in self.capture_step))
        return self._replace(deviation=deviation, capture_step=measured)


NONE = Feedback()
"""As if no sensor were there."""
