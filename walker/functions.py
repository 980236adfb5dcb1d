"""Functions of one variable: bounds, roots, trajectory pieces with set ends, the linear inverted pendulum."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, NamedTuple, TypeVar

import numpy as np

from bridge.body.quantities import GRAVITY
from bridge.types import Array, Vec2


def clip(value: float, lower: float, upper: float) -> float:
    """`value`, or the nearer of two bounds."""
    return max(lower, min(value, upper))


_ROOT_TOLERANCE: Final = 4.0 * 2.0**-52
"""Relative tolerance: four units in the last place."""
_MAX_ITERATIONS: Final = 100


def brent(function: Callable[[float], float], low: float, high: float, tolerance: float) -> float:
    """Root of a continuous function between two points of opposite sign, by Brent's method.

    The same steps as `scipy.optimize.brentq`, without loading SciPy's optimisers into the walker.

    Args:
        function: negative at one end and positive at the other.
        low: one end.
        high: other end.
        tolerance: absolute, of the root.
    """
    previous, current = low, high
    at_previous, at_current = function(previous), function(current)
    opposite, at_opposite, step, last_step = previous, at_previous, current - previous, current - previous
    for _ in range(_MAX_ITERATIONS):
        if at_previous != 0.0 and (at_previous < 0.0) != (at_current < 0.0):
            opposite, at_opposite = previous, at_previous
            last_step = step = current - previous
        if abs(at_opposite) < abs(at_current):
            previous, current, opposite = current, opposite, current
            at_previous, at_current, at_opposite = at_current, at_opposite, at_current
        delta = 0.5 * (tolerance + _ROOT_TOLERANCE * abs(current))
        middle = 0.5 * (opposite - current)
        if at_current == 0.0 or abs(middle) < delta:
            break
        trial = 0.0
        if abs(last_step) > delta and abs(at_current) < abs(at_previous):
            if previous == opposite:  # secant
                trial = -at_current * (current - previous) / (at_current - at_previous)
            else:  # inverse quadratic interpolation
                to_previous = (at_previous - at_current) / (previous - current)
                to_opposite = (at_opposite - at_current) / (opposite - current)
                trial = (
                    -at_current
                    * (at_opposite * to_opposite - at_previous * to_previous)
                    / (to_opposite * to_previous * (at_opposite - at_previous))
                )
            good = 2.0 * abs(trial) < min(abs(last_step), 3.0 * abs(middle) - delta)
        else:
            good = False
        last_step, step = (step, trial) if good else (middle, middle)
        previous, at_previous = current, at_current
        current += step if abs(step) > delta else (delta if middle > 0.0 else -delta)
        at_current = function(current)
    return current


class MotionState(NamedTuple):
    """Position, velocity and acceleration of one coordinate."""

    position: float
    velocity: float
    acceleration: float


def quintic(start: float, end: float, duration: float, t: float) -> MotionState:
    """Fifth-degree polynomial from rest to rest, zero velocity and acceleration at both ends (thesis 3.6).

    Args:
        start: position at t = 0.
        end: position at t = duration.
        duration: > 0, s.
        t: s; before and after the piece the end values hold.
    """
    if t <= 0.0:
        return MotionState(start, 0.0, 0.0)
    if t >= duration:
        return MotionState(end, 0.0, 0.0)
    s = t / duration
    d = end - start
    return MotionState(
        start + d * s**3 * (10.0 - 15.0 * s + 6.0 * s * s),
        d / duration * 30.0 * s * s * (1.0 - s) ** 2,
        d / duration**2 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
    )


def lift_spline(start: float, middle: float, end: float, duration: float, t: float) -> MotionState:
    """C2 cubic spline through `start`, `middle` at half time and `end`, zero slope at both ends (3.3.1).

    The clamped spline on three equidistant knots has the slope 3 (end - start) / (2 duration) at the middle
    knot; each half is then the cubic Hermite piece between its knots.

    Args:
        start: At t = 0, m.
        middle: At half of the duration, m.
        end: From `duration` on, m.
        duration: s.
        t: Time since the beginning, s.
    """
    half = 0.5 * duration
    slope = 1.5 * (end - start) / duration
    if t <= 0.0:
        return MotionState(start, 0.0, 0.0)
    if t >= duration:
        return MotionState(end, 0.0, 0.0)
    if t < half:
        return _hermite(start, middle, 0.0, slope, half, t)
    return _hermite(middle, end, slope, 0.0, half, t - half)


def _hermite(p0: float, p1: float, v0: float, v1: float, duration: float, t: float) -> MotionState:
    s = t / duration
    a = 2.0 * (p0 - p1) + duration * (v0 + v1)
    b = 3.0 * (p1 - p0) - duration * (2.0 * v0 + v1)
    return MotionState(
        p0 + duration * v0 * s + b * s * s + a * s**3,
        v0 + (2.0 * b * s + 3.0 * a * s * s) / duration,
        (2.0 * b + 6.0 * a * s) / duration**2,
    )


def smoothstep(s: float) -> float:
    """The cubic from 0 to 1 with zero slopes at its ends, constant outside."""
    s = max(0.0, min(s, 1.0))
    return s * s * (3.0 - 2.0 * s)


Number = TypeVar("Number", float, Array)


@dataclass(frozen=True, slots=True)
class LinearPendulum:
    """One horizontal direction at a time; both obey the same equation x'' = nu^2 (x - x_zmp)."""

    height: float
    """Height of the centre of mass above the ground, m."""

    @property
    def nu(self) -> float:
        """Natural frequency sqrt(g / z), 1/s (3.10)."""
        return math.sqrt(GRAVITY / self.height)

    def zmp(self, position: Number, acceleration: Number) -> Number:
        """Zero moment point (3.4), m.

        Args:
            position: of the centre of mass, m, any shape.
            acceleration: of the centre of mass, m/s^2, of the same shape.
        """
        return position - acceleration * self.height / GRAVITY

    def motion(self, t: float, position: float, velocity: float) -> MotionState:
        """Motion of the centre of mass while the zero moment point rests at 0 (3.10).

        Args:
            t: s, before or after the moment at which the state is given.
            position: of the centre of mass at t = 0, m.
            velocity: there, m/s.
        """
        nu = self.nu
        sinh, cosh = math.sinh(nu * t), math.cosh(nu * t)
        a, b = position, velocity / nu
        return MotionState(
            a * cosh + b * sinh,
            a * nu * sinh + b * nu * cosh,
            a * nu**2 * cosh + b * nu**2 * sinh,
        )


def capture_point(place: Vec2, velocity: Vec2, omega: float) -> Vec2:
    """Zero moment point at which the centre of mass comes to rest above it: place + velocity / omega, m.

    Args:
        place: of the centre of mass, x and y, m.
        velocity: of the centre of mass, m/s.
        omega: natural frequency of its pendulum, 1/s.
    """
    (x, y), (v_x, v_y) = place, velocity
    return x + v_x / omega, y + v_y / omega


class SmoothedRate:
    """Rate of a vector: its difference from cycle to cycle, smoothed.

    Args:
        time_constant: of the smoothing, s.
    """

    def __init__(self, time_constant: float) -> None:
        self._time_constant = time_constant
        self._last: Array | None = None
        self.rate: Array = np.zeros(3)
        """1/s; zeros before the second value."""

    def update(self, value: Array, dt: float) -> Array:
        """The rate at the next value.

        Args:
            value: shape (3,).
            dt: time since the last one, s; after none the rate stays.
        """
        if self._last is not None and dt > 0.0:
            share = min(dt / self._time_constant, 1.0)
            self.rate = self.rate + share * ((value - self._last) / dt - self.rate)
        self._last = value
        return self.rate
