"""What of a set of parameters a body cannot walk, found out before the first joint moves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from bridge.datasheet import Body
from bridge.datasheet.model import Side
from bridge.datasheet.sole import sole_hull
from bridge.joints import LEG_SLOTS
from walker.errors import UnreachableError
from walker.gait.huang.foot import FootPath, FootShape, Placement
from walker.gait.huang.multibody import Bodies
from walker.gait.huang.parameters import HuangParameters, refuse
from walker.gait.huang.spline import even
from walker.kinematics.limits import limit_violations

if TYPE_CHECKING:
    from walker.gait.huang.gait import HuangGait

CLIPPED: Final = math.radians(0.5)
"""Excess over a range that is clipped in silence, as in `walker.walkable`."""
_TOLERANCE: Final = 1e-9
"""m; rounding of a sole that rolls on the ground."""
_DT: Final = 0.02
_STEPS: Final = 4
"""A first step, two periodic ones, and the beginning of another."""
_SIDES: Final[tuple[Side, Side]] = ("L", "R")


def check_swing(p: HuangParameters, body: Body) -> None:
    """No foot goes through flat ground, in a whole step or in a half one.

    Raises:
        ConfigurationError: says how deep and when.
    """
    if p.l_FA < (least := 2.0 * max(-y for _, y in body.foot.sole)):
        refuse(
            f"at l_FA = {p.l_FA} m the soles overlap by {1e3 * (least - p.l_FA):.1f} mm; l_FA must be at least "
            f"{least:.4f} m"
        )
    shape = FootShape.of(body)
    along = sole_hull(body, "L")[:, 0]
    for share in (1.0, 0.5):
        path = FootPath(p, shape, Placement(0.0), Placement(share * 2.0 * p.D_s), share)
        times = even(0.0, path.settled, 400)
        heights = path.sole(times, along)[1].min(axis=1)
        if heights.min() < -_TOLERANCE:
            when = times[int(np.argmin(heights))]
            refuse(
                f"the foot goes {-1e3 * heights.min():.2f} mm into the ground at {when:.2f} s of its cycle; "
                f"raise H_ao = {p.H_ao} m or lower q_b, q_f"
            )


def check_walk(body: Body, bodies: Bodies, gait: HuangGait, ground_ahead: float) -> None:
    """A walk over all edges of the known ground, and two steps more, is within reach and joint ranges.

    Args:
        body: data sheet.
        bodies: of it.
        gait: in its initial stand.
        ground_ahead: place of the last edge, m.

    Raises:
        ConfigurationError: names the foot or joint, the step, and by how much.
    """
    walk = gait
    try:
        for walk in gait.trial(_DT):
            angles = bodies.joint_angles(*walk.pose())
            _check_ranges(body, angles, walk.steps + 1)
            if walk.steps >= _STEPS and walk.stance_x > ground_ahead:
                return
    except UnreachableError as error:
        refuse(
            f"step {walk.steps + 1}, its first such pose: {error}; lower H_max = {walk.parameters.H_max} m, or "
            "bring D_s, D_max, l_FA, y_d or y_m down"
        )


def _check_ranges(body: Body, angles: list[float], step: int) -> None:
    """Joint ranges of a pose; AnkleRoll, which may be cut in the air, is left to `walker.walkable`."""
    for side in _SIDES:
        for joint, excess in limit_violations(body, side, [angles[slot] for slot in LEG_SLOTS[side]]):
            if joint.endswith("AnkleRoll") or abs(excess) < CLIPPED:
                continue
            bound = "above" if excess > 0.0 else "below"
            refuse(
                f"step {step}: {joint} would stand {math.degrees(abs(excess)):.1f} deg {bound} its range on a "
                f"{body.name} in its first such pose; change q_b, q_f, H_ao, H_min, D_s or the times"
            )
