"""Footholds of the omnidirectional gait: the nominal ones of a velocity, their limits, and the capture point.

Capture-point end conditions determine the capture point from which a walk stays bounded. For a ZMP p(t)
the capture point obeys xi' = omega (xi - p) (Englsberger et al., T-RO 31(2), 2015). It stays bounded only if it
begins at xi(0) = omega int_0^inf exp(-omega t) p(t) dt. In step i, of duration T, the ZMP moves in the first
T_DSP straight from p_{i-1} to p_i and rests there. With q = exp(-omega T) and
rho = 1 - (1 - exp(-omega T_DSP)) / (omega T_DSP) the integral is

    xi(0) = sum_i q^(i-1) ((1 - q) p_i - rho (p_i - p_{i-1})),  i = 1, 2, ...
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Final

from bridge.planar import Pose2D
from bridge.types import Side, Vec2, Vec3
from walker.gaits.omni.parameters import OmniParameters
from walker.gaits.plan import SIGN

CLOSING_TOLERANCE: Final = 0.02
"""m between the foothold beside the stance foot and the one that the walk needs, where the feet are closed."""


def rate_limited_velocity(p: OmniParameters, now: Vec3, wanted: Vec3) -> Vec3:
    """The velocity of the next step on the way to a wanted one, within the gait's accelerations."""
    x, y, yaw = (
        _nearer(v, goal, up * p.T, down * p.T)
        for v, goal, up, down in zip(now, wanted, p.max_acceleration, p.max_deceleration, strict=True)
    )
    return x, y, yaw


def _nearer(v: float, goal: float, up: float, down: float) -> float:
    """One component: a change of sign passes through rest."""
    goal = goal if v * goal >= 0.0 else 0.0
    bound = down if abs(goal) < abs(v) else up
    return goal if abs(goal - v) < bound + 1e-9 else v + math.copysign(bound, goal - v)


def steps_to_rest(p: OmniParameters, velocity: Vec3) -> int:
    """Number of steps after one at a velocity until the feet can close, within the gait's accelerations.

    They close in a step at no velocity; after a fast one another step at no velocity comes before it.
    """
    decelerations = [a * p.T for a in p.max_deceleration]
    steps = max(math.ceil(abs(v) / a - 1e-9) for v, a in zip(velocity, decelerations, strict=True))
    x, y, _ = (max(abs(v) - (steps - 1) * a, 0.0) for v, a in zip(velocity, decelerations, strict=True))
    return steps + (steps > 0 and math.hypot(x, 2.0 * y) * p.T > CLOSING_TOLERANCE)


def nominal_foothold(p: OmniParameters, stance: Pose2D, swing: Side, velocity: Vec3) -> Pose2D:
    """The next foothold of a walk at a constant velocity.

    Sideways the foot on that side makes the way of two steps and the other one follows, so that the feet
    are never closer than the step width; most of a turn is made by the foot that turns its toes outward.

    Args:
        p: of the gait.
        stance: foothold of the stance foot.
        swing: the other foot.
        velocity: m/s, m/s, rad/s.
    """
    sign, (x, y, yaw) = SIGN[swing], velocity
    way = 2.0 * y * p.T if y * sign > 0.0 else 0.0
    turn = 2.0 * yaw * p.T * (p.turn_share if yaw * sign > 0.0 else 1.0 - p.turn_share)
    half = 0.5 * sign * p.l_FA
    # The middle between the feet moves straight in the mean of its headings.
    middle = stance.pose(Pose2D(0.0, half, 0.5 * turn))
    middle = Pose2D(*middle.point(x * p.T, way), stance.yaw + turn)
    return middle.pose(Pose2D(0.0, half))


def clip_foothold(p: OmniParameters, stance: Pose2D, swing: Side, foothold: Pose2D) -> Pose2D:
    """The foothold nearest to a wished one that the leg reaches without treading on the other foot.

    Args:
        p: of the gait.
        stance: foothold of the stance foot.
        swing: the other foot.
        foothold: wished.
    """
    sign = SIGN[swing]
    x, y = stance.local(foothold.x, foothold.y)
    x = min(max(x, -p.max_length), p.max_length)
    y = sign * min(max(sign * y, p.min_width), p.max_width)
    return Pose2D(*stance.point(x, y), foothold.yaw)


def zmp_under(p: OmniParameters, side: Side, foothold: Pose2D) -> Vec2:
    """The point under a sole where the ZMP of single support is planned, m."""
    return foothold.point(p.zmp_x, SIGN[side] * p.zmp_y)


def transfer_weight(omega: float, duration: float) -> float:
    """rho: the weight that the ZMP of the step before keeps, for a transfer within `duration` (s)."""
    s = omega * duration
    return 1.0 + math.expm1(-s) / s if s > 0.0 else 0.0


def bounded_capture_point(omega: float, T: float, rho: float, zmps: Sequence[Vec2]) -> Vec2:
    """Capture point at the beginning of a step from which the walk stays bounded, m.

    Args:
        omega: natural frequency of the pendulum, 1/s.
        T: duration of a step, s.
        rho: see `transfer_weight`.
        zmps: p_0 (of the step before), p_1, p_2, ...; the last one is kept for ever.
    """
    q = math.exp(-omega * T)
    x = y = 0.0
    weight = 1.0
    for before, here in itertools.pairwise(zmps):
        x += weight * ((1.0 - q) * here[0] - rho * (here[0] - before[0]))
        y += weight * ((1.0 - q) * here[1] - rho * (here[1] - before[1]))
        weight *= q
    return x + weight * zmps[-1][0], y + weight * zmps[-1][1]
