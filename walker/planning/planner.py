"""A gait under way: its state, and where in the walk frame the walk began."""

from __future__ import annotations

from typing import Any

from bridge.types import Vec3
from walker.planning.feedback import NONE, Feedback
from walker.planning.gait import Gait, GaitCommand, standing_plan
from walker.planning.order import WalkOrder
from walker.planning.plan import Foothold, Plan


class WalkPlanner:
    """Steps a gait and moves its plans to the place where the walk began.

    Args:
        gait: to walk by.
        order: how far to walk.
        origin: middle between the feet at the beginning.
        steps: number of steps that were completed before.
        velocity: as in `GaitCommand`.
    """

    def __init__(
        self,
        gait: Gait[Any],
        order: WalkOrder,
        origin: Foothold = Foothold(),  # noqa: B008 (a value)
        steps: int = 0,
        velocity: Vec3 | None = None,
    ) -> None:
        self.order, self.velocity = order, velocity
        self._gait, self._origin, self._steps = gait, origin, steps
        self._state = gait.initial()
        self.plan = standing_plan(gait).moved(origin, steps)
        """The newest one."""

    def step(self, dt: float, *, walk: bool, feedback: Feedback = NONE) -> Plan:
        """The next plan.

        Args:
            dt: time since the last one, s.
            walk: as in `GaitCommand`.
            feedback: as in `GaitCommand`, in the walk frame.
        """
        local = feedback.seen_from(self._origin)
        if self.order.target is not None:
            # on the way to a place the steering takes up what the walk misses
            local = local._replace(velocity=NONE.velocity)
        last = max(self.order.steps - self._steps, 0)
        plan, self._state = self._gait.step(self._state, dt, GaitCommand(walk, self.velocity, last, local))
        self.plan = plan.moved(self._origin, self._steps)
        return self.plan
