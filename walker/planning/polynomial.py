"""Trajectory pieces with set ends."""

from __future__ import annotations

from typing import NamedTuple


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
