"""Which motion gets a robot up that lies, and when to try."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from bridge.body import Body
from bridge.messages import SensorFrame
from walker.planning.motion import Lying, Motion, MotionPlayer, load_motion, lying, motion_names

REST: Final = 2.0
"""s that a robot lies before it gets up: longer than its guard takes no command after a fall."""
TRIES: Final = 5
"""After which a robot stays where it is."""


@dataclass(frozen=True)
class Recovery:
    """The motions that get a body up, by what of it is below."""

    body: Body
    motions: dict[Lying, Motion]

    @staticmethod
    def of(body: Body) -> Recovery | None:
        """Of the motions that come with the package, those seen to work on this body; None: there are none."""
        found = {
            side: motion
            for motion in map(load_motion, motion_names())
            for side in motion.begins
            if body.name in motion.bodies
        }
        return Recovery(body, found) if found else None

    def player(self, frame: SensorFrame) -> MotionPlayer | None:
        """A motion for how the robot lies; None: there is none."""
        motion = self.motions.get(lying(frame.angle))
        return None if motion is None else MotionPlayer(motion, self.body)
