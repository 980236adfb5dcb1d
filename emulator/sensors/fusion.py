"""The angle that the inertial board fuses: accelerometer at rest, gyroscope in motion (vendor's description).

Nothing but the samples of the two sensors goes in. The filter is assumed; the vendor's own is not published.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge.types import Vec2, Vec3
from emulator.compiled import compilable, compiled
from emulator.sensors.parameters import FusedAngleParameters
from emulator.vectors import add, cross, length, put, scaled

Vector = NDArray[np.float64]
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

STATE: Final = np.dtype(
    [
        ("up", np.float64, 3),  # unit vector, Torso frame
        ("bias", np.float64, 3),  # of the gyroscope, rad/s
        ("mean_rate", np.float64, 3),  # rad/s
        ("mean_acceleration", np.float64, 3),  # m/s^2
        ("rate_variance", np.float64),
        ("acceleration_variance", np.float64),
        # for how long, s
        ("quiet", np.float64),
        ("doubted", np.float64),
        ("rested", np.float64),
        ("at_rest", np.bool_),  # the unit believes that it rests
    ]
)
"""What the unit knows."""


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
        motion_pull = 1.0 / parameters.motion_time
        pulls = (motion_pull, max(1.0 / parameters.rest_time, motion_pull))
        self.constants = (gravity, *pulls, parameters.bias_time)
        """The last arguments of `fuse`."""
        self.state = np.zeros(1, STATE)
        """Of the unit."""
        self.state["up"] = _unit(acceleration)
        self.state["mean_acceleration"] = acceleration

    @property
    def angle(self) -> Vec2:
        """AngleX (roll) and AngleY (pitch), rad."""
        x, y, z = self.state["up"][0].tolist()
        return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))


@compilable
def _square(a: Vec3) -> float:
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]


@compilable
def _unit(vector: Vec3) -> Vec3:
    size = length(vector)
    return scaled(vector, 1.0 / size) if size > 0.0 else (0.0, 0.0, 1.0)


@compilable
def _vector(a: Vector) -> Vec3:
    return a[0], a[1], a[2]


@compiled
def fuse(
    state: NDArray[Any],
    acceleration: Vec3,
    rate: Vec3,
    dt: float,
    gravity: float,
    motion_pull: float,
    rest_pull: float,
    bias_time: float,
) -> None:
    """Take in the means of both sensors since the last call.

    Args:
        state: Of `STATE`, (1,); changed.
        acceleration: Mean, m/s^2.
        rate: Likewise, rad/s.
        dt: Since the last call, s.
        gravity: m/s^2.
        motion_pull: Towards the accelerometer in motion, 1/s.
        rest_pull: At rest.
        bias_time: In which the bias is learnt at rest, s.
    """
    now = state[0]
    _judge_rest(now, acceleration, rate, dt, gravity)
    pull, bias = motion_pull, _vector(now.bias)
    if now.at_rest:
        now.rested = min(now.rested + dt, bias_time)
        pull = max(rest_pull, 1.0 / now.rested)
        learnt = add(_vector(now.mean_rate), scaled(bias, -1.0))
        bias = add(bias, scaled(learnt, dt / now.rested))
        put(now.bias, bias)
    turn = scaled(add(rate, scaled(bias, -1.0)), dt)
    # up is fixed in the world, so in the torso it turns the other way; to second order in the angle
    before = _vector(now.up)
    way = cross(before, turn)
    up = add(before, add(way, scaled(cross(way, turn), 0.5)))
    # not the acceleration's direction: only the vectors themselves average to gravity
    put(now.up, _unit(add(scaled(up, 1.0 - pull * dt), scaled(acceleration, pull * dt / gravity))))


@compilable
def _judge_rest(now: Any, acceleration: Vec3, rate: Vec3, dt: float, gravity: float) -> None:
    """Means and variances of both sensors, and for how long they have been quiet."""
    weight = dt / WINDOW
    mean_rate, mean_acceleration = _vector(now.mean_rate), _vector(now.mean_acceleration)
    off_rate = add(rate, scaled(mean_rate, -1.0))
    off_acceleration = add(acceleration, scaled(mean_acceleration, -1.0))
    mean_rate = add(mean_rate, scaled(off_rate, weight))
    mean_acceleration = add(mean_acceleration, scaled(off_acceleration, weight))
    put(now.mean_rate, mean_rate)
    put(now.mean_acceleration, mean_acceleration)
    now.rate_variance += weight * (_square(off_rate) - now.rate_variance)
    now.acceleration_variance += weight * (_square(off_acceleration) - now.acceleration_variance)
    quiet = (
        now.rate_variance < QUIET_RATE**2
        and now.acceleration_variance < QUIET_ACCELERATION**2
        and _square(mean_rate) < MAX_BIAS**2
        and abs(length(mean_acceleration) - gravity) < MAX_DEPARTURE
    )
    now.quiet = now.quiet + dt if quiet else 0.0
    turn = add(mean_rate, scaled(_vector(now.bias), -1.0))
    lean = add(mean_acceleration, scaled(_vector(now.up), -gravity))
    doubt = now.rested >= FIRST_REST and (_square(turn) > BIAS_STEP**2 or _square(lean) > LEAN_STEP**2)
    now.doubted = now.doubted + dt if quiet and doubt else 0.0
    now.at_rest = now.quiet >= QUIET_TIME and (not doubt or now.doubted >= LONG_QUIET_TIME)
