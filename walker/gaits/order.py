"""The order of a walk, the gait under way that carries it out, and the steering to a place."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, Final

import msgspec

from bridge.errors import ConfigurationError
from bridge.planar import Pose2D
from bridge.types import Vec3
from walker.gaits.gait import Gait, GaitCommand, GaitParameters, Limits, standing_plan
from walker.gaits.plan import NO_FEEDBACK, Feedback, Plan


class WalkOrder(msgspec.Struct, frozen=True, kw_only=True):
    """Bounds of a walk: by steps, by time, to a place, or none."""

    steps: int = 0
    """Steps to walk, the closing step included; 0: no bound. At least 2 when bounded."""
    duration: float = math.inf
    """s of walking after which the robot closes its feet and stands."""
    target: Vec3 | None = None
    """Place to walk to, from the middle between the feet at the beginning: forward and to the left, m, and
    turn, rad. For gaits that have `limits`; by the odometry."""
    share: float = 1.0
    """Share of the gait's limits that is used on the way to the target."""
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


ARRIVAL_DISTANCE: Final = 0.008
"""m from the place at which the walk is over."""
ARRIVAL_ANGLE: Final = 0.03
"""rad from the heading, likewise."""
_CLOSE_ERROR: Final = 4.0
"""Error, as `_error` counts it, below which a walk is over if another step leads no closer."""
_LEAST_IMPROVEMENT: Final = 0.2
"""Least reduction of the error by such a step."""
_BRAKING_SHARE: Final = 0.7
"""Part of the gait's acceleration that is planned on: a velocity changes at the next step only."""
_SHORTEST_DURATIONS: Final[Vec3] = (0.25, 0.5, 0.5)
"""s planned for a short rest of the way: a step; sideways and turning, where the outer foot follows, two."""


@dataclass(frozen=True)
class Steering:
    """Leads to a goal.

    Straight, while the heading turns at a steady rate; slowed down in time to stop there.
    """

    limits: Limits
    goal: Pose2D
    """Middle between the feet at the end, in the frame of the odometry."""
    share: float = 1.0
    """Share of the limits that is used."""

    def remaining(self, here: Pose2D) -> Vec3:
        """Remaining way and turn, in the frame of `here`, m, m, rad."""
        x, y = here.local(self.goal.x, self.goal.y)
        return x, y, math.remainder(self.goal.yaw - here.yaw, math.tau)

    def arrived(self, now: Pose2D, later: Pose2D) -> bool:
        """Whether the walk is over: at the goal, or close to it while another step leads no closer.

        Feedback can move the footholds of a slow walk by more than its velocity corrects.

        Args:
            now: pose between the feet if they close after this step, in the frame of the odometry.
            later: the same after one more step on the spot.
        """
        step = _SHORTEST_DURATIONS[0]
        rest = (way - step * v for way, v in zip(self.remaining(later), self.velocity(later), strict=True))
        error = _error(self.remaining(now))
        return error < 1.0 or (error < _CLOSE_ERROR and error < _error(tuple(rest)) + _LEAST_IMPROVEMENT)

    def velocity(self, here: Pose2D) -> Vec3:
        """Velocity of the next step, m/s, m/s, rad/s.

        Args:
            here: middle between the feet, in the frame of the odometry.
        """
        way = self.remaining(here)
        time = self.limits.share(way) / self.share
        for rest, acceleration in zip(way, self.limits.max_acceleration, strict=True):
            # v^2 = 2 a s, and v = s / time
            time = max(time, math.sqrt(abs(rest) / (2.0 * _BRAKING_SHARE * acceleration)))
        x, y, turn = (rest / max(time, last) for rest, last in zip(way, _SHORTEST_DURATIONS, strict=True))
        return x, y, turn


def _error(way: tuple[float, ...]) -> float:
    """Error of a way and turn that remain, m, m, rad; 1 where the walk is over."""
    x, y, turn = way
    return max(math.hypot(x, y) / ARRIVAL_DISTANCE, abs(turn) / ARRIVAL_ANGLE)


class WalkEnd:
    """Transforms the rest of the plan to the robot's pose by the odometry.

    Args:
        latency: from a command to the motion that the sensors report, s.
        cycle: of the robot, s.
    """

    def __init__(self, latency: float, cycle: float) -> None:
        self._planned: deque[Pose2D] = deque(maxlen=1 + round(latency / cycle))

    def update(self, here: Pose2D, plan: Plan) -> tuple[Pose2D, ...]:
        """`Plan.stop_poses` in the frame of the odometry.

        Args:
            here: middle between the feet by the odometry.
            plan: in force.
        """
        self._planned.append(plan.middle)
        then = self._planned[0]
        return tuple(here.pose(then.local_pose(end)) for end in plan.stop_poses)


class WalkPlanner:
    """Steps a gait and moves its plans to the place where the walk began.

    Args:
        gait: to walk by.
        order: bounds of the walk.
        origin: middle between the feet at the beginning.
        steps: number of steps completed before.
        velocity: as in `GaitCommand`.
    """

    def __init__(
        self,
        gait: Gait[Any],
        order: WalkOrder,
        origin: Pose2D = Pose2D(),  # noqa: B008 (a value)
        steps: int = 0,
        velocity: Vec3 | None = None,
    ) -> None:
        self.order, self.velocity = order, velocity
        self._gait, self._origin, self._steps = gait, origin, steps
        self._state = gait.initial()
        self.plan = standing_plan(gait).transformed(origin, steps)
        """The newest one."""

    def step(self, dt: float, *, walk: bool, feedback: Feedback = NO_FEEDBACK) -> Plan:
        """The next plan.

        Args:
            dt: time since the last one, s.
            walk: as in `GaitCommand`.
            feedback: as in `GaitCommand`, in the walk frame.
        """
        local = feedback.expressed_in(self._origin)
        if self.order.target is not None:
            # on the way to a place the steering compensates the walk's error
            local = local._replace(velocity=NO_FEEDBACK.velocity)
        last = max(self.order.steps - self._steps, 0)
        plan, self._state = self._gait.step(self._state, dt, GaitCommand(walk, self.velocity, last, local))
        self.plan = plan.transformed(self._origin, self._steps)
        return self.plan
