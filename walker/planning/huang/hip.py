"""The hip in the periodic cycle: x by (8), (9), z by (7), and y by the same means.

Time counts from the beginning of double support; the rear foot stands at x = 0, the front foot at D_s, and y is
positive towards the front foot, which the cycle is to stand on. The source walks in the plane. Sideways the hip
has three knots: `y_d` off the path at both ends of single support, `y_m` in its middle, and every cycle is the
mirror image of the one before.

The printed closed form (10) violates its own conditions (8), (9); the periodic spline on x_h - (D_s / T_c) t
meets them. The middle of single support is T_d + (T_c - T_d) / 2, not the (T_c - T_d) / 2 printed in (7).
"""

from __future__ import annotations

from typing import NamedTuple

from walker.functions import MotionState
from walker.planning.huang.parameters import HuangParameters
from walker.planning.huang.spline import Cubic, periodic


class Choice(NamedTuple):
    """Where the hip is at the ends of single support and, sideways, in its middle; see `HuangParameters`, m."""

    x_sd: float
    x_ed: float
    y_d: float
    y_m: float


def hip_x(p: HuangParameters, x_sd: float, x_ed: float) -> Cubic:
    """X less the even motion D_s / T_c t, periodic (8), (9)."""
    mean = p.D_s / p.T_c
    values = (x_ed, p.D_s - x_sd - mean * p.T_d, x_ed)
    return periodic((0.0, p.T_d, p.T_c), [p.x_0 + value for value in values])


def hip_y(p: HuangParameters, y_d: float, y_m: float) -> Cubic:
    """y, antiperiodic."""
    return periodic((0.0, p.T_d, 0.5 * (p.T_c + p.T_d), p.T_c), (-y_d, y_d, y_m, y_d), sign=-1.0)


def hip_z(p: HuangParameters) -> Cubic:
    """Height of the hip joints (7), from the middle of double support to that of the next one."""
    times = (0.5 * p.T_d, 0.5 * (p.T_c + p.T_d), p.T_c + 0.5 * p.T_d)
    return periodic(times, (p.H_min, p.H_max, p.H_min))


def ends_of_cycle(p: HuangParameters, choice: Choice) -> tuple[MotionState, MotionState]:
    """X and y at the beginning of a cycle: where the phases from and to rest join on."""
    x = hip_x(p, choice.x_sd, choice.x_ed).at(0.0)
    return MotionState(x.position, x.velocity + p.D_s / p.T_c, x.acceleration), hip_y(
        p, choice.y_d, choice.y_m
    ).at(0.0)
