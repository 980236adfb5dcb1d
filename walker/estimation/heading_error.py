"""By how much the robot turned off its plan.

A foot that is put down while it turns, or while the other leg swings fast, spins on the floor, and the hips
turn farther than commanded. The plan sees neither.
"""

from __future__ import annotations

import math
from collections import deque

from walker.planning.plan import Plan


class HeadingError:
    """Compares the odometry's heading with that of the plan, from the beginning of each walk on.

    Args:
        latency: from a command to the motion that the sensors report, s.
        cycle: of the robot, s.
    """

    def __init__(self, latency: float, cycle: float) -> None:
        self._planned: deque[float] = deque(maxlen=1 + round(latency / cycle))
        self._began = 0.0
        """Heading of the robot less the planned one when the walk began, rad."""

    def update(self, heading: float, plan: Plan) -> float:
        """Heading of the robot less the planned one, rad; 0 until the first step.

        Args:
            heading: mean of both soles by the odometry, rad.
            plan: in force.
        """
        planned = plan.middle.yaw
        if plan.phase in ("stand", "start"):
            self._planned.clear()
            self._began = heading - planned
        self._planned.append(planned)
        return math.remainder(heading - self._planned[0] - self._began, math.tau)
