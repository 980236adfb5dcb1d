"""Where the robot's feet come to stand when its walk ends."""

from __future__ import annotations

from collections import deque

from walker.planning.plan import Foothold, Plan


class WalkEnd:
    """Lays what is left of the plan to where the robot is by the odometry.

    Args:
        latency: from a command to the motion that the sensors report, s.
        cycle: of the robot, s.
    """

    def __init__(self, latency: float, cycle: float) -> None:
        self._planned: deque[Foothold] = deque(maxlen=1 + round(latency / cycle))

    def update(self, here: Foothold, plan: Plan) -> tuple[Foothold, ...]:
        """`Plan.ends` in the frame of the odometry.

        Args:
            here: middle between the feet by the odometry.
            plan: in force.
        """
        self._planned.append(plan.middle)
        then = self._planned[0]
        return tuple(
            Foothold(*here.point(*then.local(end.x, end.y)), here.yaw + end.yaw - then.yaw) for end in plan.ends
        )
