"""Where feet and ZMP are, from a track: kinematics of many cycles at once."""

from __future__ import annotations

import numpy as np

from bridge.body import Body
from bridge.body.joints import LEG_SLOTS
from bridge.body.kinematics import sole_in_torso
from bridge.rotations import matrix
from bridge.types import SIDES, Side
from nao_hil.runs.track import LEG_COLUMNS, Array, Track


def soles_in_torso(body: Body, side: Side, joints: Array) -> Array:
    """Poses of a sole (frame 9) in the Torso frame, shape (n, 4, 4), m.

    Args:
        body: Data sheet.
        side: Foot.
        joints: Channel `joints` or `request` of a track.
    """
    columns = [LEG_COLUMNS.index(slot) for slot in LEG_SLOTS[side]]
    return np.array([sole_in_torso(body, side, angles) for angles in joints[:, columns].tolist()]).reshape(
        -1, 4, 4
    )


def ankle_in_hip(body: Body, side: Side, joints: Array) -> Array:
    """p_(i,0)^(i,8): the ankle in the frame of its hip, torso axes, shape (n, 3), m; arguments as above."""
    soles = soles_in_torso(body, side, joints)
    hip = np.array([0.0, (1.0 if side == "L" else -1.0) * body.lengths.HipOffsetY, -body.lengths.HipOffsetZ])
    return np.asarray(soles[:, :3, 3] + body.lengths.FootHeight * soles[:, :3, 2] - hip)


def soles_in_world(body: Body, side: Side, track: Track) -> Array:
    """Poses of a sole in the world frame, shape (n, 4, 4), m."""
    pose = np.zeros((len(track), 4, 4))
    pose[:, :3, :3], pose[:, :3, 3], pose[:, 3, 3] = matrix(track["orientation"]), track["torso"], 1.0
    return pose @ soles_in_torso(body, side, track["joints"])


def zmp_margin(track: Track, body: Body) -> Array:
    """Distance of the true ZMP from the edge of the stance sole in single support, m, negative outside.

    The sole is taken as its bounding rectangle, as the thesis does (3.1).

    Returns:
        Shape (n,), NaN where there is no single support or no load.
    """
    margin = np.full(len(track), np.nan)
    outline = np.array(body.foot.sole)
    low, high = outline.min(axis=0), outline.max(axis=0)
    for side, phase in zip(SIDES, ("SSL", "SSR"), strict=True):
        rows = np.flatnonzero(track.during(phase) & np.isfinite(track["zmp"][:, 0]))
        if not rows.size:
            continue
        soles = soles_in_world(body, side, Track(track.rows[rows]))
        off = track["zmp"][rows] - soles[:, :2, 3]
        local = np.einsum("nij,ni->nj", soles[:, :2, :2], off)
        if side == "R":
            local[:, 1] *= -1.0
        margin[rows] = np.minimum(local - low, high - local).min(axis=1)
    return margin
