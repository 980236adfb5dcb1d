"""The thesis' chain of transforms of one leg, a frame at a time (Prenner 2011, 2.9 to 2.18, table 2.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from bridge.body.kinematics import PSI_K, Transform, homogeneous, side_sign, translation
from bridge.body.model import Body
from bridge.rotations import R_pitch, R_roll, R_yaw
from bridge.types import Side

LegFrame = Literal[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, "FM"]
_HERE = (0.0, 0.0, 0.0)


def leg_steps(body: Body, side: Side, angles: Sequence[float]) -> dict[LegFrame, Transform]:
    """The transform from each frame of the leg to the one before it (table 2.2).

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

    Returns:
        H_0^j, shape (4, 4), m, by frame j: 0 to 9 and "FM".
    """
    frames: dict[LegFrame, Transform] = {}
    H = np.eye(4)
    for frame, step in leg_steps(body, side, angles).items():
        H = H @ step
        frames[frame] = H
    return frames
