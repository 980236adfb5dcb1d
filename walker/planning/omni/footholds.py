"""Footholds of the omnidirectional gait: where the feet go at a constant velocity, and where they may go."""

from __future__ import annotations

import math

from bridge.types import Side, Vec2, Vec3
from walker.planning.omni.parameters import OmniParameters
from walker.planning.plan import SIGN, Foothold


def approached(p: OmniParameters, now: Vec3, wanted: Vec3) -> Vec3:
    """The velocity of the next step on the way to a wanted one, within the gait's accelerations."""
    x, y, yaw = (
        _nearer(v, goal, up * p.T, down * p.T)
        for v, goal, up, down in zip(now, wanted, p.max_acceleration, p.max_deceleration, strict=True)
    )
    return x, y, yaw


def _nearer(v: float, goal: float, up: float, down: float) -> float:
    """One component: a change of sign goes by way of rest."""
    goal = goal if v * goal >= 0.0 else 0.0
    bound = down if abs(goal) < abs(v) else up
    return goal if abs(goal - v) < bound + 1e-9 else v + math.copysign(bound, goal - v)


def steps_to_rest(p: OmniParameters, velocity: Vec3) -> int:
    """Number of steps after one at a velocity until one at rest, within the gait's accelerations."""
    return max(math.ceil(abs(v) / (a * p.T) - 1e-9) for v, a in zip(velocity, p.max_deceleration, strict=True))


def following(p: OmniParameters, stance: Foothold, swing: Side, velocity: Vec3) -> Foothold:
    """The next foothold of a walk at a constant velocity.

    Sideways the foot on that side makes the way of two steps and the other one comes after, so that the feet
    are never closer than the step width; most of a turn is made by the foot that turns its toes outward.

    Args:
        p: of the gait.
        stance: foothold of the foot that stands.
        swing: the other foot.
        velocity: m/s, m/s, rad/s.
    """
    sign, (x, y, yaw) = SIGN[swing], velocity
    way = 2.0 * y * p.T if y * sign > 0.0 else 0.0
    turn = 2.0 * yaw * p.T * (p.turn_share if yaw * sign > 0.0 else 1.0 - p.turn_share)
    half = 0.5 * sign * p.l_FA
    # The middle between the feet goes straight in the mean of its headings.
    middle = Foothold(*stance.point(0.0, half), stance.yaw + 0.5 * turn)
    middle = Foothold(*middle.point(x * p.T, way), stance.yaw + turn)
    return Foothold(*middle.point(0.0, half), middle.yaw)


def allowed(p: OmniParameters, stance: Foothold, swing: Side, foothold: Foothold) -> Foothold:
    """The foothold nearest to a wished one that the leg reaches without treading on the other foot.

    Args:
        p: of the gait.
        stance: foothold of the foot that stands.
        swing: the other foot.
        foothold: wished.
    """
    sign = SIGN[swing]
    x, y = stance.local(foothold.x, foothold.y)
    x = min(max(x, -p.max_length), p.max_length)
    y = sign * min(max(sign * y, p.min_width), p.max_width)
    return Foothold(*stance.point(x, y), foothold.yaw)


def zmp_under(p: OmniParameters, side: Side, foothold: Foothold) -> Vec2:
    """The point under a sole where the ZMP of single support is planned, m."""
    return foothold.point(p.zmp_x, SIGN[side] * p.zmp_y)
