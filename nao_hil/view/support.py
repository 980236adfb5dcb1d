"""What the robot stands on, as the pictures show it."""

from __future__ import annotations

from typing import Final

import numpy as np

from bridge.body.kinematics import FloatingBase
from bridge.polygon import SupportPolygon, convex_hull
from bridge.types import SIDES
from nao_hil.analysis.diagnosis import Stand

FAR: Final = 0.03
"""A capture point this far outside the support polygon is marked, m."""


def soles_that_touch(kinematics: FloatingBase, stand: Stand) -> SupportPolygon | None:
    """The hull of the soles that touch the ground, world frame; None in flight."""
    soles = [kinematics.sole_in_world(s, stand.robot.feet[s])[:, :2] for s in SIDES if stand.contacts.of(s)]
    return SupportPolygon(convex_hull(np.vstack(soles))) if soles else None


def tips(stand: Stand, polygon: SupportPolygon) -> bool:
    """Whether the robot is about to fall: its capture point is far outside, or nothing bears it."""
    return stand.zmp is None or polygon.margin(stand.capture) < -FAR
