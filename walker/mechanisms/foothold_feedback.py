"""Pose2D feedback: deviation of the robot from its plan's pendulum, and of its feet from their footholds.

Reads: joint angles, lean of the torso, plans of the last latency.
Gives: `Feedback.deviation` and `Feedback.foothold_bias` for the gait.

The encoders and the torso's lean place the centre of mass and the swing foot over the standing sole, where
the plan of a latency before wanted them to be over that foothold. The joints' deflection and backlash put the
centre of mass off the plan in each step alike. That is no disturbance: the slow mean of each stance foot, part
by part of the step, is subtracted. The same deflection shifts the landings off their footholds: it is learnt.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.body.kinematics import FloatingBase
from bridge.planar import Pose2D
from bridge.types import Array, Fraction, NotNegative, Positive, Side, Vec2
from walker.estimation.state import ComState
from walker.gaits.plan import NO_FEEDBACK, OTHER_SIDE, Feedback, Plan

_PARTS: Final = 8
"""Parts of a step, each with a mean of its own."""
_LEARN_STEPS: Final = 6
"""Number of steps after which the mean is learnt, and the whole deviation counts."""
_FIRST_STEPS: Final = 2
"""Number of steps after which deviations beyond `_UNLEARNT` count: a worn robot tips back in its third."""
_UNLEARNT: Final = 0.015
"""m of the capture point's deviation that may be the joints' deflection and backlash, without their mean."""
_VELOCITY_CHANGE: Final = (0.1, 0.1, 1.0)
"""Change of the velocity, m/s, m/s, rad/s, after which the mean counts as unlearnt."""
_LARGEST_MISS: Final = 0.02
"""m of a miss that counts in one step."""


class DeviationParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of the deviation's filter and prediction."""

    position_gain: Fraction = 0.5
    """Share of a cycle's innovation that is added to the deviation."""
    velocity_gain: Fraction = 0.12
    """Share of the innovation over the cycle that is added to its rate."""
    mean_gain: Fraction = 0.05
    """Share of a deviation that is added to the mean."""
    first_mean_gain: tuple[Fraction, Fraction] = (0.3, 0.1)
    """The same in the first steps and after a change of the velocity, along and across the stance foot."""
    max_innovation: Positive = 0.015
    """Largest difference from the mean that counts in it, m."""
    placement_gain: Fraction = 0.2
    """Share of a foot's miss that is learnt in a step."""
    max_placement: NotNegative = 0.025
    """Bound of the placement, m."""
    max_placement_change: NotNegative = 0.003
    """Bound of its change from step to step, m."""


class _Measured(NamedTuple):
    """Less the plan, in the frame of the stance foot, shape (2,), m."""

    com: Array
    """Deviation of the centre of mass."""
    miss: Array
    """From the swing foot to its foothold."""


class DeviationEstimator:
    """Follows the deviation of a walk whose plans have a pendulum.

    Args:
        parameters: of filter and prediction.
        base: kinematics of the body.
        cycle: of the robot, s.
        latency: over which the deviation is predicted, s.
        deviation: estimate the capture point's deviation.
        placement: learn the shift of the landings.
    """

    def __init__(
        self,
        parameters: DeviationParameters,
        base: FloatingBase,
        cycle: float,
        latency: float,
        *,
        deviation: bool,
        placement: bool,
    ) -> None:
        self._p, self._latency = parameters, latency
        self._deviation_on, self._placement_on = deviation, placement
        self._base = base
        self._plans: deque[Plan] = deque(maxlen=1 + round(latency / cycle))
        self._previous_plan: Plan | None = None
        self._first_step = 0
        """Number of the first step."""
        self._stance_yaw = 0.0
        """Yaw of the stance foot; position and rate are in its frame."""
        self._position: Array = np.zeros(2)
        self._rate: Array = np.zeros(2)
        self._miss: Array = np.zeros(2)
        self._mean: dict[Side, Array] = {"L": np.zeros((_PARTS, 2, 2)), "R": np.zeros((_PARTS, 2, 2))}
        """Position, and rate over omega, of each part, m."""
        self._learnt = 0.0
        """Placement that is learnt, m; it stays from walk to walk."""
        self._placement = 0.0
        """In force, m."""
        self._velocity: Array = np.zeros(3)
        """Mean velocity while learning."""

    def update(self, state: ComState, plan: Plan, dt: float) -> Feedback:
        """One cycle.

        Args:
            state: centre of mass and soles.
            plan: in force.
            dt: time since the last cycle, s.
        """
        if plan.pendulum is None or not (self._deviation_on or self._placement_on):
            return NO_FEEDBACK
        self._plans.append(plan)
        then, before = self._plans[0], self._previous_plan
        self._previous_plan = then
        if before is not None and before.support != "both" and then.step != before.step:
            self._learn_placement()
        if then.support == "both":
            self._first_step, self._rate, self._placement = then.step, np.zeros(2), 0.0
            return NO_FEEDBACK
        measured = self._measured(state, then, then.support)
        self._miss = measured.miss
        if before is None or then.support != before.support:
            yaw = then.foot(then.support).yaw
            self._position, self._rate = measured.com, _turned(self._rate, self._stance_yaw - yaw)
            self._stance_yaw = yaw
        elif dt > 0.0:
            innovation = measured.com - (self._position + dt * self._rate)
            self._position = self._position + dt * self._rate + self._p.position_gain * innovation
            self._rate = self._rate + self._p.velocity_gain / dt * innovation
        return Feedback(self._deviation(then, plan), self._placement)

    def _deviation(self, then: Plan, now: Plan) -> Vec2:
        """Deviation of the capture point from that of the plan in force now, walk frame, m."""
        if then.support == "both" or then.pendulum is None or now.pendulum is None:
            return NO_FEEDBACK.deviation
        p, omega = self._p, then.pendulum.omega
        steps = then.step - self._first_step
        change = np.subtract(then.pendulum.velocity, self._velocity)
        self._velocity += change * (p.mean_gain / _PARTS if steps >= _LEARN_STEPS else 1.0)
        unlearnt = min(float(np.max(np.abs(change) / _VELOCITY_CHANGE)), 1.0) if steps >= _LEARN_STEPS else 1.0
        mean = self._mean[then.support][min(int(then.progress * _PARTS), _PARTS - 1)]
        off = np.array([self._position, self._rate / omega]) - mean
        if then.progress < 1.0:  # a step that is prolonged is no usual one
            gain = p.mean_gain + unlearnt * (np.array(p.first_mean_gain) - p.mean_gain)
            bound = p.max_innovation * (1.0 + unlearnt)
            mean += gain * np.clip(off, -bound, bound)
        if not self._deviation_on or steps < _FIRST_STEPS:
            return NO_FEEDBACK.deviation
        off = math.exp(omega * self._latency) * (off[0] + off[1])
        bound = unlearnt * _UNLEARNT
        off -= np.clip(off, -bound, bound)
        x, y = _turned(off, self._stance_yaw)
        (a, b), (c, d) = now.pendulum.moved, then.pendulum.moved
        return float(x) - (a - c), float(y) - (b - d)

    def _learn_placement(self) -> None:
        """The end of a step: learn from its miss, and set the placement of the next one."""
        if self._placement_on:
            p = self._p
            # a change that is still under way is not learnt
            miss = float(self._miss[0]) - (self._learnt - self._placement)
            learnt = self._learnt + p.placement_gain * min(max(miss, -_LARGEST_MISS), _LARGEST_MISS)
            self._learnt = min(max(learnt, -p.max_placement), p.max_placement)
            change = self._learnt - self._placement
            self._placement += min(max(change, -p.max_placement_change), p.max_placement_change)

    def _measured(self, state: ComState, then: Plan, side: Side) -> _Measured:
        assert then.pendulum is not None
        centres, foot, other = self._base.centres, then.foot(side).foothold, OTHER_SIDE[side]
        sole, swing_sole = state.soles[side][:2], state.soles[other][:2]
        measured = Pose2D(yaw=-state.headings[side])
        middle = foot.point(*centres[side][:2])
        planned = Pose2D(*middle, foot.yaw)
        wanted = then.pendulum.target.point(*centres[other][:2])
        com = np.subtract(measured.point(*(state.position[:2] - sole)), planned.local(*then.pendulum.com))
        miss = np.subtract(planned.local(*wanted), measured.point(*(swing_sole - sole)))
        return _Measured(com, miss)


def _turned(vector: Array, yaw: float) -> Array:
    return np.array(Pose2D(yaw=yaw).point(float(vector[0]), float(vector[1])))
