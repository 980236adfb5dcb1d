"""Which parameters of the dynamic gait a body can walk: every bound, named when it is violated."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.quantities import GRAVITY
from bridge.body.sole import sole_hull
from bridge.errors import ConfigurationError
from bridge.polygon import convex_hull
from walker.planning.dynamic.step import DynamicParameters, StepPlan
from walker.planning.dynamic.transfer import Transfer
from walker.planning.plan import Plan


def check_distances(p: DynamicParameters) -> None:
    """Bounds without which there is no step at all: 0 < e_su < e_s1 < d_0.

    Raises:
        ConfigurationError: names the bound and by how much it is violated.
    """
    if p.e_s1 >= p.d_0:
        _refuse(
            f"e_s1 = {p.e_s1} m reaches {1e3 * (p.e_s1 - p.d_0):.1f} mm beyond the middle of the stance foot; "
            f"it must be less than d_0 = l_FA / 2 = {p.d_0} m"
        )
    if p.e_su >= p.e_s1:
        _refuse(
            f"e_su = {p.e_su} m is {1e3 * (p.e_su - p.e_s1):.1f} mm too large for a step of positive duration; "
            f"it must be less than e_s1 = {p.e_s1} m"
        )


def check_balance(p: DynamicParameters, plan: StepPlan, transfer: Transfer, body: Body) -> None:
    """The feet do not overlap, do not slip (3.9), and the ZMP stays inside them in every phase.

    Raises:
        ConfigurationError: names the bound and by how much it is violated.
    """
    inner = -min(y for _, y in body.foot.sole)
    if p.l_FA < 2.0 * inner:
        _refuse(
            f"at l_FA = {p.l_FA} m the soles overlap by {1e3 * (2.0 * inner - p.l_FA):.1f} mm; l_FA must be at "
            f"least {2.0 * inner:.4f} m"
        )
    _check_friction(p, plan, transfer)
    centre = np.array([body.foot.centre[0], 0.0])
    outside = _beyond(sole_hull(body, "L"), centre[None, :])
    if outside > 0.0:
        _refuse(f"the middle of the foot {centre} lies {1e3 * outside:.1f} mm outside the sole")
    ends = centre + np.array([[plan.S_a, -p.e_su], [plan.S_a + plan.S_b, p.e_su]])
    outside = _beyond(_feet(p, body, plan.length), ends)
    if outside > 0.0:
        _refuse(f"with S_a0 = {p.S_a0} m the ZMP leaves the feet by {1e3 * outside:.1f} mm in double support")
    together = _edges(_feet(p, body, 0.0) - centre)
    outside = max(transfer.furthest(way * nx, ny) + d for nx, ny, d in together for way in (1.0, -1.0))
    if outside > 0.0:
        _refuse(
            f"with T_start = {p.T_start} s the ZMP leaves the feet by {1e3 * outside:.1f} mm on the way from "
            "rest to A or from D to rest; choose T_start nearer to 1 s, or a smaller S_a0 or e_s1"
        )


def check_legs(p: DynamicParameters, body: Body, walk: Iterable[Plan]) -> None:
    """No leg is stretched or folded further than it goes in a sampled walk.

    The hip joints are taken to move with the centre of mass and to stand above the ankles at rest (the mass
    ahead of them as far as the sole's middle is ahead of the ankle: within 8 mm on every NAO).

    Raises:
        ConfigurationError: names the bound and by how much it is violated.
    """
    length = body.lengths
    thigh, tibia = length.ThighLength, length.TibiaLength
    max_reach = thigh + tibia
    knee = body.joints["LKneePitch"].upper
    min_reach = math.sqrt(thigh**2 + tibia**2 + 2.0 * thigh * tibia * math.cos(knee))
    reaches = [
        math.hypot(
            plan.com[0] - body.foot.centre[0] - foot.x,
            plan.com[1] + side * length.HipOffsetY - foot.y,
            p.l_GH - foot.z,
        )
        for plan in walk
        for foot, side in ((plan.left, 1.0), (plan.right, -1.0))
    ]
    if max(reaches) > max_reach:
        _refuse(
            f"with l_GH = {p.l_GH} m and S_a0 = {p.S_a0} m a leg is stretched "
            f"{1e3 * (max(reaches) - max_reach):.1f} mm beyond its {max_reach:.4f} m; l_GH or S_a0 must be "
            "smaller"
        )
    if min(reaches) < min_reach:
        _refuse(
            f"with l_GH = {p.l_GH} m and l_lift = {p.l_lift} m a leg is folded "
            f"{1e3 * (min_reach - min(reaches)):.1f} mm below the {min_reach:.4f} m that the knee allows; l_GH "
            "must be larger or l_lift smaller"
        )


def _check_friction(p: DynamicParameters, plan: StepPlan, transfer: Transfer) -> None:
    """(3.9), for the resultant of both axes: the cone of friction knows no axes, so this implies (3.9a, b)."""
    # In single support the mass is furthest from the ZMP at touch-down.
    touch_down = plan.pendulum.nu**2 * math.hypot(plan.S_a, p.d_0 - p.e_su)
    for where, acceleration in (
        ("at touch-down", touch_down),
        ("while starting and stopping", transfer.acceleration()),
    ):
        excess = acceleration - p.mu * GRAVITY
        if excess > 0.0:
            _refuse(
                f"the acceleration {where}, {acceleration:.2f} m/s^2, is {excess:.2f} m/s^2 more than the "
                f"friction bound mu g (3.9); mu must be at least {acceleration / GRAVITY:.3f}"
            )


def _feet(p: DynamicParameters, body: Body, length: float) -> NDArray[np.float64]:
    """Corners of both soles, the right ankle at x = 0, the left one a step length ahead, shape (n, 2)."""
    right = sole_hull(body, "R") + np.array((0.0, -p.d_0))
    left = sole_hull(body, "L") + np.array((length, p.d_0))
    return np.concatenate((right, left))


def _beyond(corners: NDArray[np.float64], points: NDArray[np.float64]) -> float:
    """Largest distance of the points from the convex hull of the corners, m; negative inside."""
    edges = _edges(corners)
    return float((points @ edges[:, :2].T + edges[:, 2]).max())


def _edges(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges of the convex hull of points: outward normals and offsets, n . x + d = 0, shape (n, 3)."""
    hull = np.array(convex_hull(corners))
    along = np.roll(hull, -1, axis=0) - hull
    normals = np.column_stack((along[:, 1], -along[:, 0])) / np.linalg.norm(along, axis=1)[:, None]
    return np.column_stack((normals, -np.einsum("ij,ij->i", normals, hull)))


def _refuse(sentence: str) -> None:
    raise ConfigurationError(f"dynamic gait: {sentence}.")
