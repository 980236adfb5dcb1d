"""Which samples of a recording tell something about a joint's own drive.

The model has one joint at a time. A sample counts while the joint's own command moves, or has just moved, and
no other one of the same limb does. Fast motion counts for few joints: whoever shakes a leg or an arm moves all
its joints, which the model leaves out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from bridge.body import Body, joint_tree
from bridge.body.joints import INDEX, LEG_JOINTS, TORSO
from bridge.types import Array
from nao_hil.identification.readings import Signals, hangs

AFTER: Final = 0.7
"""Time for which a joint is watched after its command has moved, s."""
FAST: Final = 0.6
"""Speed of a command from which on motion is fast, rad/s."""
QUICK: Final = ("HeadYaw", "HeadPitch", "AnklePitch", "AnkleRoll")
"""Joints whose fast motion counts: with it the model is as near to the engine's robot as in slow motion, the
rounding of the encoder (measured; with ElbowRoll and ElbowYaw it is ten times as far off, because a forearm
stops somewhere within its backlash; WristYaw is taken to be like them)."""
_EPSILON: Final = 1e-7
_STEADY: Final = 0.02
"""Change of the stiffness that does not matter."""
LEGS: Final = frozenset(joint for joints in LEG_JOINTS.values() for joint in joints)
"""Not used while they carry the robot."""


def useful(body: Body, signals: Signals, joints: Sequence[str]) -> NDArray[np.bool_]:
    """Samples that count, (n, joints).

    Args:
        body: Data sheet.
        signals: The recording.
        joints: Columns of the result.
    """
    columns = [INDEX[joint] for joint in joints]
    command, position = signals.command[:, columns], signals.position[:, columns]
    way = np.abs(np.diff(np.nan_to_num(command), axis=0, prepend=np.nan_to_num(command[:1])))
    moving = _lately(way, signals.cycle) > _EPSILON
    fast = _lately(way, signals.cycle) > FAST * signals.cycle
    limbs = [_limb(body, joint) for joint in joints]
    stiffness = signals.stiffness[:, columns]
    steady = np.abs(stiffness - np.median(stiffness, axis=0)) < _STEADY
    found = moving & steady & np.isfinite(command) & np.isfinite(position) & signals.measured[:, None]
    if hangs(body, signals) is False:
        found[:, [i for i, joint in enumerate(joints) if joint in LEGS]] = False
    for i, joint in enumerate(joints):
        others = [k for k in range(len(joints)) if k != i and limbs[i] & limbs[k]]
        found[:, i] &= ~moving[:, others].any(axis=1)
        if not joint.endswith(QUICK):
            found[:, i] &= ~fast[:, i]
    return np.asarray(found)


def stretches(samples: NDArray[np.bool_], longest: int) -> NDArray[np.int64]:
    """Number of the unbroken stretch of each sample that counts, all joints together; -1 for the others.

    Args:
        samples: (n, joints)
        longest: Samples after which another stretch begins.
    """
    rows = np.arange(len(samples))[:, None]
    starts = samples & ~np.vstack([np.zeros_like(samples[:1]), samples[:-1]])
    since = rows - np.maximum.accumulate(np.where(starts, rows, 0), axis=0)
    starts = samples & (since % longest == 0)
    numbers = np.cumsum(starts.ravel(order="F")).reshape(samples.shape, order="F") - 1
    return np.where(samples, numbers, -1)


def _lately(way: Array, cycle: float) -> Array:
    """The largest way of a cycle in the last `AFTER`."""
    size = round(AFTER / cycle)
    return np.asarray(maximum_filter1d(way, size, axis=0, origin=(size - 1) // 2, mode="nearest"))


def _limb(body: Body, joint: str) -> frozenset[str]:
    """Names of the limbs that this joint moves: its own; the motor of both hips moves two."""
    if joint == "LHipYawPitch":
        return frozenset({"LHipYawPitch", "RHipYawPitch"})
    tree = joint_tree(body)
    while tree[joint].parent != TORSO:
        joint = tree[joint].parent
    return frozenset({joint})
