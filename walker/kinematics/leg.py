"""Forward kinematics of one leg: the thesis' chain of transforms (Prenner 2011, 2.9 to 2.18).

Frames: 0 leg, 3 HipYawPitch, 4 HipRoll, 5 HipPitch, 6 KneePitch, 7 AnklePitch, 8 AnkleRoll (the foot's body
frame), 9 sole below the ankle, FM middle of the sole. Frames 1 and 2 hold the slanted HipYawPitch axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, Literal

import numpy as np

from bridge.datasheet.model import Body, Side
from walker.kinematics.transforms import (
    R_pitch,
    R_roll,
    R_yaw,
    Transform,
    homogeneous,
    translation,
)

PSI_K: Final = -math.pi / 4
"""Slant of the right HipYawPitch axis against the leg's z axis, rad (2.10); the left leg has the opposite."""

LegFrame = Literal[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, "FM"]
Matrix3 = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

_HERE: Final = (0.0, 0.0, 0.0)
_H: Final = math.sqrt(0.5)


def side_sign(side: Side) -> float:
    """+1 for the left leg, whose y offsets are positive; -1 for the right."""
    return 1.0 if side == "L" else -1.0


def leg_steps(body: Body, side: Side, angles: Sequence[float]) -> dict[LegFrame, Transform]:
    """The transform from each frame of the leg to the one before it (table 2.2).

    Args:
        body: The data sheet.
        side: The leg.
        angles: HipYawPitch, HipRoll, HipPitch, KneePitch, AnklePitch, AnkleRoll, rad.

    Returns:
        H_(j-1)^j by frame j, in chain order; frame 0 against the Torso, FM against frame 9.
    """
    phi_2, psi_4, theta_5, theta_6, theta_7, psi_8 = angles
    length, sign = body.lengths, side_sign(side)
    # Left leg: H_L0^L1 = H_R2^R3, H_L2^L3 = H_R0^R1, H_L1^L2(phi_2) = H_R1^R2(-phi_2).
    slant = -sign * PSI_K
    x_fm, y_fm = body.foot.centre
    return {
        0: translation(0.0, sign * length.HipOffsetY, -length.HipOffsetZ),
        1: homogeneous(R_roll(slant), _HERE),
        2: homogeneous(R_yaw(-sign * phi_2), _HERE),
        3: homogeneous(R_roll(-slant), _HERE),
        4: homogeneous(R_roll(psi_4), _HERE),
        5: homogeneous(R_pitch(theta_5), _HERE),
        6: homogeneous(R_pitch(theta_6), (0.0, 0.0, -length.ThighLength)),
        7: homogeneous(R_pitch(theta_7), (0.0, 0.0, -length.TibiaLength)),
        8: homogeneous(R_roll(psi_8), _HERE),
        9: translation(0.0, 0.0, -length.FootHeight),
        "FM": translation(x_fm, sign * y_fm, 0.0),
    }


def leg_chain(body: Body, side: Side, angles: Sequence[float]) -> dict[LegFrame, Transform]:
    """All frames of a leg in the Torso frame (2.9 to 2.18).

    Args:
        body: The data sheet.
        side: The leg.
        angles: HipYawPitch, HipRoll, HipPitch, KneePitch, AnklePitch, AnkleRoll, rad.

    Returns:
        H_0^j, shape (4, 4), m, by frame j: 0 to 9 and "FM".
    """
    frames: dict[LegFrame, Transform] = {}
    H = np.eye(4)
    for frame, step in leg_steps(body, side, angles).items():
        H = H @ step
        frames[frame] = H
    return frames


def hip_rotation(side: Side, hip_yaw_pitch: float) -> Matrix3:
    """R_0^3 of a leg, multiplied out with psi_k = -45 degrees (2.22, and its mirror image for the left)."""
    sign = side_sign(side)
    s, c = _H * math.sin(hip_yaw_pitch), math.cos(hip_yaw_pitch)
    diagonal, skew = 0.5 * (c + 1.0), 0.5 * sign * (c - 1.0)
    return (c, sign * s, s), (-sign * s, diagonal, skew), (-s, skew, diagonal)


def foot_in_torso(body: Body, side: Side, angles: Sequence[float]) -> Transform:
    """Pose of the foot (frame 8, AnkleRoll) in the Torso frame, shape (4, 4), m.

    `leg_chain(...)[8]` multiplied out, for the control cycle.

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
    """Pose of the sole below the ankle (frame 9, 2.17) in the Torso frame, shape (4, 4), m."""
    return foot_in_torso(body, side, angles) @ translation(0.0, 0.0, -body.lengths.FootHeight)
