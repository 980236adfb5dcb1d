"""The angle that the inertial board fuses: accelerometer while the rate is steady, gyroscope otherwise.

Its inputs are the samples of both sensors. The vendor describes the switch (thesis 4.2.1), not the filter; its
form and numbers are fitted to the AngleY of a real board (an H25 on a swing).
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge.types import Array, Vec2, Vec3
from emulator.compiled import compilable, compiled
from emulator.sensors.parameters import FusedAngleParameters
from emulator.vectors import add, cross, length, put, scaled

WINDOW: Final = 0.09
"""Time over which the rate must be steady, s."""
MAX_SAMPLES: Final = 32
"""Longest window in samples."""

STATE: Final = np.dtype(
    [
        ("up", np.float64, 3),  # unit vector, Torso frame
        ("rates", np.float64, (MAX_SAMPLES, 3)),  # the last ones, rad/s
        ("count", np.int64),  # of all samples
    ]
)
"""State of the filter."""


class FusedAngle:
    """AngleX and AngleY.

    The gyroscope turns the direction up; the accelerometer pulls it, with one time constant while the rate is
    steady and another one while it changes. A body that turns evenly has a steady rate, so the board then
    follows its
    accelerometer: the angle jumps by ten degrees on a swing.
    The accelerometer is above the ankle, so a torso that begins to lean reads as leaning the other way at
    first: with h its height over the pivot, the angle is theta (1 - (h/g) s^2 / (1 + T s)). A unit without a Z
    axis does not see how turning about the vertical moves the lean of a body around: up to a degree of error in
    a walk of such a body.

    With R = Rz Ry Rx the torso's orientation, up in the Torso frame is
    (-sin AngleY, cos AngleY sin AngleX, cos AngleY cos AngleX).

    Args:
        gravity: m/s^2.
        acceleration: First accelerometer sample, m/s^2; the angle starts exactly there.
        parameters: Time constants and threshold.
        step: Of the reported angles, rad; 0: none.
    """

    def __init__(
        self, gravity: float, acceleration: Vec3, parameters: FusedAngleParameters, step: float = 0.0
    ) -> None:
        p = parameters
        self.constants = (gravity, p.motion_time, p.rest_time, p.rest_rate)
        """The last arguments of `fuse`."""
        self.state = np.zeros(1, STATE)
        """State of the unit."""
        self.state["up"] = _unit(acceleration)
        self._step = step

    @property
    def angle(self) -> Vec2:
        """AngleX (roll) and AngleY (pitch), rad."""
        x, y, z = self.state["up"][0].tolist()
        roll, pitch = math.atan2(y, z), math.atan2(-x, math.hypot(y, z))
        if self._step == 0.0:
            return roll, pitch
        return round(roll / self._step) * self._step, round(pitch / self._step) * self._step


@compilable
def _unit(vector: Vec3) -> Vec3:
    size = length(vector)
    return scaled(vector, 1.0 / size) if size > 0.0 else (0.0, 0.0, 1.0)


@compilable
def _vector(a: Array) -> Vec3:
    return a[0], a[1], a[2]


@compiled
def fuse(
    state: NDArray[Any],
    acceleration: Vec3,
    rate: Vec3,
    dt: float,
    gravity: float,
    motion_time: float,
    rest_time: float,
    rest_rate: float,
) -> None:
    """Take in the means of both sensors since the last call.

    Args:
        state: Of `STATE`, (1,); changed.
        acceleration: Mean, m/s^2.
        rate: Likewise, rad/s.
        dt: Since the last call, s.
        gravity: m/s^2.
        motion_time: Time constant towards the accelerometer while the rate changes, s.
        rest_time: And while it is steady.
        rest_rate: Largest standard deviation of a steady rate, rad/s.
    """
    now = state[0]
    time = rest_time if _spread(now, rate, dt) < rest_rate else motion_time
    pull = -math.expm1(-dt / time)
    turn = scaled(rate, dt)
    # up is fixed in the world, so in the torso it turns the other way; to second order in the angle
    before = _vector(now.up)
    way = cross(before, turn)
    up = add(before, add(way, scaled(cross(way, turn), 0.5)))
    # not the acceleration's direction: only the vectors themselves average to gravity
    put(now.up, _unit(add(scaled(up, 1.0 - pull), scaled(acceleration, pull / gravity))))


@compilable
def _spread(now: Any, rate: Vec3, dt: float) -> float:
    """Standard deviation of the rate over the window, the axis with the largest, rad/s."""
    put(now.rates[now.count % MAX_SAMPLES], rate)
    now.count += 1
    number = min(max(int(WINDOW / dt + 0.5), 2), MAX_SAMPLES, now.count)
    largest = 0.0
    for axis in range(3):
        total = squares = 0.0
        for back in range(number):
            value = now.rates[(now.count - 1 - back) % MAX_SAMPLES, axis] - rate[axis]
            total += value
            squares += value * value
        largest = max(largest, squares / number - (total / number) ** 2)
    return math.sqrt(max(largest, 0.0))
