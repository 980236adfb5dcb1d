"""The angle that the inertial board fuses: accelerometer at rest, gyroscope in motion (vendor's description).

Nothing but the samples of the two sensors goes in. The filter is assumed; the vendor's own is not published.
"""

from __future__ import annotations

import math
from typing import Final

from bridge.types import Vec2, Vec3
from emulator.sensors.parameters import FusedAngleParameters
from emulator.vectors import add, cross, length, scaled

WINDOW: Final = 0.2
"""Time constant of the running means and variances that tell rest from motion, s."""
QUIET_TIME: Final = 0.5
"""How long the samples must have been quiet before the unit believes that it rests, s."""
QUIET_RATE: Final = 0.015
"""Maximum standard deviation of the rate at rest, rad/s."""
QUIET_ACCELERATION: Final = 0.35
"""Maximum standard deviation of the acceleration at rest, m/s^2."""
MAX_BIAS: Final = 0.05
"""Maximum mean rate that is taken for the gyroscope's bias, rad/s; a faster one is a turn."""
FIRST_REST: Final = 1.0
"""Time at rest in which the unit trusts all that it measures, s; the next limits hold after that."""
BIAS_STEP: Final = 0.005
"""Maximum change of a bias once learnt, rad/s; a larger one is a slow turn, unless it lasts."""
LEAN_STEP: Final = 0.08
"""Maximum disagreement between the fused direction up and the mean acceleration at rest, m/s^2; a larger one is
an acceleration, unless it lasts."""
LONG_QUIET_TIME: Final = 3.0
"""How long they must last to be a bias and a lean after all, s: no robot turns or speeds up so evenly then."""
MAX_DEPARTURE: Final = 0.3
"""Maximum departure of the mean acceleration's size from gravity at rest, m/s^2."""


class FusedAngle:
    """AngleX and AngleY.

    The direction up is turned by the gyroscope, less the bias it had when the body last rested, and pulled
    towards the accelerometer: at rest and in motion each with its time constant. Rest is when both sensors have
    hardly varied for a while; a body that glides at constant acceleration cannot be told from one at rest.
    The accelerometer sits over the ankle, so that a torso that begins to lean reads as leaning the other way at
    first: with h its height over the pivot, the angle is theta (1 - (h/g) s^2 / (1 + T s)). A unit without a Z
    axis does not see how turning about the vertical moves the lean of a body around: up to a degree of error in
    a walk of such a body.

    With R = Rz Ry Rx the torso's orientation, up in the Torso frame is
    (-sin AngleY, cos AngleY sin AngleX, cos AngleY cos AngleX).

    Args:
        gravity: m/s^2.
        acceleration: First accelerometer sample, m/s^2; the angle starts exactly there.
        parameters: Time constants.
    """

    def __init__(self, gravity: float, acceleration: Vec3, parameters: FusedAngleParameters) -> None:
        self._gravity = gravity
        self._motion_pull = 1.0 / parameters.motion_time
        self._rest_pull = max(1.0 / parameters.rest_time, self._motion_pull)
        self._bias_time = parameters.bias_time
        self._up = _unit(acceleration)
        self._bias: Vec3 = (0.0, 0.0, 0.0)
        self._mean_rate: Vec3 = (0.0, 0.0, 0.0)
        self._mean_acceleration = acceleration
        self._rate_variance = self._acceleration_variance = 0.0
        self._quiet = self._doubted = self._rested = 0.0
        self.at_rest = False
        """The unit believes that it rests."""

    def update(self, acceleration: Vec3, rate: Vec3, dt: float) -> None:
        """Take in the means of both sensors over the last dt seconds."""
        self._judge_rest(acceleration, rate, dt)
        pull = self._motion_pull
        if self.at_rest:
            self._rested = min(self._rested + dt, self._bias_time)
            pull = max(self._rest_pull, 1.0 / self._rested)
            learnt = add(self._mean_rate, scaled(self._bias, -1.0))
            self._bias = add(self._bias, scaled(learnt, dt / self._rested))
        turn = scaled(add(rate, scaled(self._bias, -1.0)), dt)
        # up is fixed in the world, so in the torso it turns the other way; to second order in the angle
        way = cross(self._up, turn)
        up = add(self._up, add(way, scaled(cross(way, turn), 0.5)))
        # not the acceleration's direction: only the vectors themselves average to gravity
        self._up = _unit(add(scaled(up, 1.0 - pull * dt), scaled(acceleration, pull * dt / self._gravity)))

    def _judge_rest(self, acceleration: Vec3, rate: Vec3, dt: float) -> None:
        """Means and variances of both sensors, and for how long they have been quiet."""
        weight = dt / WINDOW
        off_rate = add(rate, scaled(self._mean_rate, -1.0))
        off_acceleration = add(acceleration, scaled(self._mean_acceleration, -1.0))
        self._mean_rate = add(self._mean_rate, scaled(off_rate, weight))
        self._mean_acceleration = add(self._mean_acceleration, scaled(off_acceleration, weight))
        self._rate_variance += weight * (_square(off_rate) - self._rate_variance)
        self._acceleration_variance += weight * (_square(off_acceleration) - self._acceleration_variance)
        quiet = (
            self._rate_variance < QUIET_RATE**2
            and self._acceleration_variance < QUIET_ACCELERATION**2
            and _square(self._mean_rate) < MAX_BIAS**2
            and abs(length(self._mean_acceleration) - self._gravity) < MAX_DEPARTURE
        )
        self._quiet = self._quiet + dt if quiet else 0.0
        turn = add(self._mean_rate, scaled(self._bias, -1.0))
        lean = add(self._mean_acceleration, scaled(self._up, -self._gravity))
        doubt = self._rested >= FIRST_REST and (_square(turn) > BIAS_STEP**2 or _square(lean) > LEAN_STEP**2)
        self._doubted = self._doubted + dt if quiet and doubt else 0.0
        self.at_rest = self._quiet >= QUIET_TIME and (not doubt or self._doubted >= LONG_QUIET_TIME)

    @property
    def angle(self) -> Vec2:
        """AngleX (roll) and AngleY (pitch), rad."""
        x, y, z = self._up
        return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))


def _square(a: Vec3) -> float:
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]


def _unit(vector: Vec3) -> Vec3:
    size = length(vector)
    return scaled(vector, 1.0 / size) if size > 0.0 else (0.0, 0.0, 1.0)
