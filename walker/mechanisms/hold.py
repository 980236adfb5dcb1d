"""Hold of heading and velocity: deviation of the walk from its plan, by the odometry.

Reads: pose by the odometry, plan.
Gives: `Feedback.heading` (`HeadingError`) and `Feedback.velocity` (`VelocityHold`) for the gait.

A foot that is put down while it turns, or while the other leg swings fast, spins on the floor, and the hips
turn farther than commanded. Feet slip, joints yield, and feedback moves footholds more to one side than to the
other. The plan sees none of it; the odometry sees most.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

import msgspec
import numpy as np

from bridge.planar import Pose2D
from bridge.types import Array, NotNegative, Vec2
from walker.gaits.plan import Plan


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


_STEPS_PER_STRIDE: Final = 2
"""Steps over which a velocity is measured: sideways and in a turn both feet differ."""


class VelocityHoldParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Rate and bound of the learning."""

    gain: NotNegative = 0.2
    """Share of a stride's error that is learnt at each step."""
    max_correction: NotNegative = 0.03
    """Bound of the learnt correction, m/s, on each axis."""


class VelocityHold:
    """Learns the velocity to add to a command so that the robot walks at the commanded one.

    Args:
        parameters: of the learning.
    """

    def __init__(self, parameters: VelocityHoldParameters) -> None:
        self._p = parameters
        self._step_begin: Pose2D | None = None
        """At the beginning of the step under way; None: no step is."""
        self._step = 0
        self._elapsed = 0.0
        """Since then, s."""
        self._velocity: Array = np.zeros(2)
        """Commanded in this step, m/s."""
        self._previous_velocity: Array = np.zeros(2)
        """The same of the step before."""
        self._errors: deque[Array] = deque(maxlen=_STEPS_PER_STRIDE)
        """Commanded less measured velocity in the latest steps, m/s."""
        self._correction: Array = np.zeros(2)

    def update(self, here: Pose2D, plan: Plan, dt: float) -> Vec2:
        """The correction of the commanded velocity, forward and to the left, m/s; 0 until the second stride.

        Args:
            here: middle between the soles by the odometry, m, rad.
            plan: in force.
            dt: time since the last cycle, s.
        """
        if plan.pendulum is None or plan.support == "both":
            self._step_begin, self._correction, self._previous_velocity = None, np.zeros(2), np.zeros(2)
            self._errors.clear()
        else:
            self._elapsed += dt
            if self._step_begin is None or plan.step != self._step:
                if self._step_begin is not None:
                    self._learn(self._step_begin, here)
                    self._previous_velocity = self._velocity
                self._step_begin, self._step, self._elapsed = here, plan.step, 0.0
                self._velocity = np.array(plan.pendulum.velocity[:2])
        x, y = self._correction.tolist()
        return x, y

    def _learn(self, there: Pose2D, here: Pose2D) -> None:
        """The end of a step. A robot that changes its velocity lags behind the command: that is not learnt."""
        if not np.array_equal(self._previous_velocity, self._velocity):
            self._errors.clear()
            return
        middle = there._replace(yaw=there.yaw + 0.5 * math.remainder(here.yaw - there.yaw, math.tau))
        walked = np.array(middle.local(here.x, here.y)) / self._elapsed
        self._errors.append(self._velocity - walked)
        if len(self._errors) == _STEPS_PER_STRIDE:
            bound = self._p.max_correction
            learnt = self._correction + self._p.gain * np.mean(self._errors, axis=0)
            self._correction = np.clip(learnt, -bound, bound)
