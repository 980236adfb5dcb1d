"""What of a set of parameters a body cannot walk, found out before the first joint moves."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from bridge.body import Body
from bridge.body.inverse_kinematics import UnreachableError
from bridge.body.joints import LEG_SLOTS
from bridge.body.leg_limits import CLIPPED, limit_violations
from bridge.body.sole import sole_hull
from bridge.types import SIDES
from walker.planning.huang.foot import FootPath, FootShape, Placement
from walker.planning.huang.parameters import HuangParameters, refuse
from walker.planning.huang.spline import even

_TOLERANCE: Final = 1e-9
"""m; rounding of a sole that rolls on the ground."""


def check_swing(p: HuangParameters, body: Body) -> None:
    """No foot goes through flat ground, in a whole step or in a half one.

    Raises:
        ConfigurationError: says how deep and when.
    """
    if p.l_FA < (width := 2.0 * max(-y for _, y in body.foot.sole)):
        refuse(
            f"at l_FA = {p.l_FA} m the soles overlap by {1e3 * (width - p.l_FA):.1f} mm; l_FA must be at least "
            f"{width:.4f} m"
        )
    shape = FootShape.of(body)
    along = sole_hull(body, "L")[:, 0]
    for fraction in (1.0, 0.5):
        path = FootPath(p, shape, Placement(0.0), Placement(fraction * 2.0 * p.D_s), fraction)
        times = even(0.0, path.settled, 400)
        heights = path.sole(times, along)[1].min(axis=1)
        if heights.min() < -_TOLERANCE:
            when = times[int(np.argmin(heights))]
            refuse(
                f"the foot goes {-1e3 * heights.min():.2f} mm into the ground at {when:.2f} s of its cycle; "
                f"raise H_ao = {p.H_ao} m or lower q_b, q_f"
            )


def check_walk(p: HuangParameters, body: Body, walk: Iterable[tuple[int, list[float]]]) -> None:
    """A walk is within reach and joint ranges.

    Args:
        p: of the gait.
        body: data sheet.
        walk: steps completed and 25 joint angles, rad, at many moments; raises UnreachableError where a foot is
            out of reach.

    Raises:
        ConfigurationError: names the foot or joint, the step, and by how much.
    """
    steps = 0
    try:
        for steps, angles in walk:
            _check_ranges(body, angles, steps + 1)
    except UnreachableError as error:
        refuse(
            f"step {steps + 1}, its first such pose: {error}; lower H_max = {p.H_max} m, or "
            "bring D_s, D_max, l_FA, y_d or y_m down"
        )


def _check_ranges(body: Body, angles: list[float], step: int) -> None:
    """Joint ranges of a pose; AnkleRoll, which may be cut in the air, is left to `walker.planning.walkable`."""
    for side in SIDES:
        for joint, excess in limit_violations(body, side, [angles[slot] for slot in LEG_SLOTS[side]]):
            if joint.endswith("AnkleRoll") or abs(excess) < CLIPPED:
                continue
            bound = "above" if excess > 0.0 else "below"
            refuse(
                f"step {step}: {joint} would stand {math.degrees(abs(excess)):.1f} deg {bound} its range on a "
                f"{body.name} in its first such pose; change q_b, q_f, H_ao, H_min, D_s or the times"
            )
