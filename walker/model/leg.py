"""Forward kinematics of one leg: the thesis' chain of transforms (Prenner 2011, 2.9 to 2.18), multiplied out.

Frames: 0 leg, 3 HipYawPitch, 4 HipRoll, 5 HipPitch, 6 KneePitch, 7 AnklePitch, 8 AnkleRoll (the foot's body
frame), 9 sole below the ankle, FM middle of the sole. Frames 1 and 2 hold the slanted HipYawPitch axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from bridge.body.model import Body
from bridge.types import Matrix3, Side
from walker.model.transforms import Transform, translation

PSI_K: Final = -math.pi / 4
"""Slant of the right HipYawPitch axis against the leg's z axis, rad (2.10); the left leg has the opposite."""

_H: Final = math.sqrt(0.5)


def side_sign(side: Side) -> float:
    """+1 for the left leg, whose y offsets are positive; -1 for the right."""
    return 1.0 if side == "L" else -1.0


def hip_rotation(side: Side, hip_yaw_pitch: float) -> Matrix3:
    """R_0^3 of a leg, multiplied out with psi_k = -45 degrees (2.22, and its mirror image for the left).

    Args:
        side: The leg.
        hip_yaw_pitch: rad.
    """
    sign = side_sign(side)
    s, c = _H * math.sin(hip_yaw_pitch), math.cos(hip_yaw_pitch)
    diagonal, skew = 0.5 * (c + 1.0), 0.5 * sign * (c - 1.0)
    return (c, sign * s, s), (-sign * s, diagonal, skew), (-s, skew, diagonal)


def foot_in_torso(body: Body, side: Side, angles: Sequence[float]) -> Transform:
    """Pose of the foot (frame 8, AnkleRoll) in the Torso frame, shape (4, 4), m.

    Args:
        body: The data sheet.
        side: The leg.
        angles: HipYawPitch, HipRoll, HipPitch, KneePitch, AnklePitch, AnkleRoll, rad.
    """
    phi_2, psi_4, theta_5, theta_6, theta_7, psi_8 = angles
    length, sign = body.lengths, side_sign(side)
    knee = theta_5 + theta_6
    x = -length.ThighLength * math.sin(theta_5) - length.TibiaLength * math.sin(knee)
    z = -length.ThighLength * math.cos(theta_5) - length.TibiaLength * math.cos(knee)
    s4, c4 = math.sin(psi_4), math.cos(psi_4)
    s7, c7 = math.sin(knee + theta_7), math.cos(knee + theta_7)
    s8, c8 = math.sin(psi_8), math.cos(psi_8)
    origin = (0.0, sign * length.HipOffsetY, -length.HipOffsetZ)
    rows = []
    for (r0, r1, r2), d in zip(hip_rotation(side, phi_2), origin, strict=True):
        # One row of R_0^4 = R_0^3 R_roll(psi_4), then R_pitch(theta_5 + theta_6 + theta_7) R_roll(psi_8).
        a1, a2 = r1 * c4 + r2 * s4, r2 * c4 - r1 * s4
        n, a = r0 * c7 - a2 * s7, r0 * s7 + a2 * c7
        rows.append((n, a1 * c8 + a * s8, a * c8 - a1 * s8, r0 * x + a2 * z + d))
    rows.append((0.0, 0.0, 0.0, 1.0))
    return np.array(rows)


def sole_in_torso(body: Body, side: Side, angles: Sequence[float]) -> Transform:
    """Pose of the sole below the ankle (frame 9, 2.17) in the Torso frame, shape (4, 4), m.

    Args:
        body: The data sheet.
        side: The leg.
        angles: As for `foot_in_torso`.
    """
    return foot_in_torso(body, side, angles) @ translation(0.0, 0.0, -body.lengths.FootHeight)
