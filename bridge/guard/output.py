"""Joint angles and stiffnesses that the guard put out last, and the limited way to the next ones."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from bridge.body import Body
from bridge.body.joints import JOINTS
from bridge.body.quantities import HANDS, absent_joints
from bridge.guard.ranges import Ranges
from bridge.guard.speed import SpeedLimiter
from bridge.messages import ActuatorFrame, SensorFrame


class JointOutput:
    """What the joints were last asked for; all positions are 25 in frame order, rad, inside their ranges.

    Args:
        body: data sheet.
        speed_ratio: no joint is asked to move faster than this times its no-load speed.
    """

    def __init__(self, body: Body, speed_ratio: float) -> None:
        self.ranges = Ranges(body)
        self._limiter = SpeedLimiter(body, speed_ratio)
        absent = absent_joints(body)
        self._revolute = [i for i, joint in enumerate(JOINTS) if joint not in absent and joint not in HANDS]
        self.stiffness: tuple[float, ...] | None = None
        """25 stiffnesses put out last; None: the joints are left alone."""

    @property
    def position(self) -> tuple[float, ...] | None:
        """25 positions put out last; None: the joints are left alone."""
        return self._limiter.last if self.stiffness is not None else None

    def set_position(self, position: Sequence[float]) -> None:
        """The joints are at `position`."""
        self._limiter.last = tuple(position)

    def move_towards(
        self, position: Sequence[float], slow: Collection[int] = (), speed: float = math.inf
    ) -> tuple[float, ...]:
        """Positions of this cycle on the way to `position`.

        Args:
            position: goal.
            slow: joints that arrive together.
            speed: rad/s that none of them exceeds; the others have the drives' own limits.
        """
        return self._limiter.follow(position, slow, speed)

    def start(self, frame: SensorFrame, weak: float) -> tuple[float, ...]:
        """Where a motion begins: positions put out last, or measured ones for joints that are weak.

        Args:
            frame: measured positions.
            weak: stiffness; a joint with no more than this is where it is measured.
        """
        last, stiffness = self._limiter.last, self.stiffness
        if last is None or stiffness is None:
            return self.ranges.clip(frame.position)
        free = [i for i in self._revolute if stiffness[i] <= weak]
        if not free:
            return last
        start = list(last)
        for i in free:
            start[i] = frame.position[i]
        return self.ranges.clip(start)

    def stiffened(self, command: ActuatorFrame) -> list[int]:
        """Joints that were free and that the command makes stiff."""
        old = self.stiffness or command.stiffness
        return [i for i in self._revolute if old[i] <= 0.0 < command.stiffness[i]]

    def ways(self, start: Sequence[float], command: ActuatorFrame) -> dict[int, float]:
        """Way of each joint that is to be stiff, from `start` to the command, rad."""
        return {i: abs(start[i] - command.position[i]) for i in self._revolute if command.stiffness[i] > 0.0}
