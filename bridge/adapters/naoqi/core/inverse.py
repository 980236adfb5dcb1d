"""Inverse kinematics of effectors by damped least squares (Wampler 1986)."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Final, NamedTuple

import numpy as np

from bridge.adapters.naoqi.core.frames import RobotFrames
from bridge.body import TORSO, Body, joint_tree
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS
from bridge.body.quantities import limits
from bridge.types import Array

DAMPING: Final = 0.02
"""Damping of the least squares, in units of the weighted error (m)."""
METRES_PER_RADIAN: Final = 0.1
"""m that an error of 1 rad weighs."""
MAX_STEP: Final = 0.3
"""rad of one iteration."""
STALLED_STEP: Final = 1e-5
"""rad of an iteration below which the search ends: the goal is out of reach."""
ERROR_TOLERANCE: Final = 1e-5
"""Weighted error at which the search ends, m."""


class Goal(NamedTuple):
    """Target of an effector."""

    effector: str
    target: Array
    """In the Torso frame, (4, 4)."""
    axes: Array
    """Axes that count, rows of (n, 6): directions of translation and rotation in the Torso frame."""


def masked_axes(mask: int, R: Array) -> Array:
    """The axes of a mask's bits 1 to 32 (x, y, z, wx, wy, wz) of a space, (n, 6).

    Args:
        R: the space's rotation in the Torso frame, (3, 3).
    """
    axes = np.zeros((6, 6))
    axes[:3, :3], axes[3:, 3:] = R.T, METRES_PER_RADIAN * R.T
    return axes[[bool(mask >> bit & 1) for bit in range(6)]]


class InverseKinematics:
    """Search for joint positions."""

    def __init__(self, body: Body, frames: RobotFrames) -> None:
        self._frames = frames
        self._tree = joint_tree(body)
        self._limits = {joint: limits(body, JOINTS[INDEX_WITH_MIRROR[joint]]) for joint in body.joints}

    def chain(self, effector: str) -> list[str]:
        """Joints between the torso and an effector."""
        joint, above = self._frames.effectors[effector].link, []
        while joint != TORSO:
            above.append(joint)
            joint = self._tree[joint].parent
        return above[::-1]

    def solve(
        self, position: Sequence[float], goals: Sequence[Goal], iterations: int, pinned: Collection[int] = ()
    ) -> list[float]:
        """The 25 positions nearest to all goals, inside the joints' ranges, rad.

        Args:
            iterations: at most.
        """
        q = np.array(position)
        chains = [self.chain(goal.effector) for goal in goals]
        slots = sorted({INDEX_WITH_MIRROR[joint] for chain in chains for joint in chain})
        held = [i for i, slot in enumerate(slots) if slot in pinned]
        if not slots:
            return list(position)
        ranges = {INDEX_WITH_MIRROR[joint]: self._limits[joint] for chain in chains for joint in chain}
        lower, upper = np.array([ranges[slot] for slot in slots]).T
        for _ in range(iterations):
            J, error = self._linearized(q, goals, chains, slots)
            J[:, held] = 0.0
            if np.abs(error).max(initial=0.0) < ERROR_TOLERANCE:
                break
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING**2 * np.eye(len(error)), error)
            step *= min(1.0, MAX_STEP / max(np.abs(step).max(), 1e-9))
            before = q[slots]
            q[slots] = np.clip(before + step, lower, upper)
            if np.abs(q[slots] - before).max() < STALLED_STEP:
                break
        return [float(x) for x in q]

    def _linearized(
        self, q: Array, goals: Sequence[Goal], chains: Sequence[Sequence[str]], slots: Sequence[int]
    ) -> tuple[Array, Array]:
        links = self._frames.links(q.tolist())
        rows, errors = [], []
        for goal, chain in zip(goals, chains, strict=True):
            here = self._frames.in_torso(goal.effector, links)
            frames = np.array([links[joint] for joint in chain])
            axes = np.einsum("nij,nj->ni", frames[:, :3, :3], [self._tree[joint].axis for joint in chain])
            J = np.zeros((6, len(slots)))
            columns = [slots.index(INDEX_WITH_MIRROR[joint]) for joint in chain]
            J[:3, columns] = np.cross(axes, here[:3, 3] - frames[:, :3, 3]).T
            J[3:, columns] = axes.T
            turn = rotation_vector(goal.target[:3, :3] @ here[:3, :3].T)
            rows.append(goal.axes @ J)
            errors.append(goal.axes @ (*(goal.target[:3, 3] - here[:3, 3]), *turn))
        return np.concatenate(rows), np.concatenate(errors)


def rotation_vector(R: Array) -> tuple[float, float, float]:
    """Axis times angle of a rotation, rad; zeros for a half turn, whose axis is ambiguous here."""
    x, y, z = 0.5 * (R[2, 1] - R[1, 2]), 0.5 * (R[0, 2] - R[2, 0]), 0.5 * (R[1, 0] - R[0, 1])
    sine = math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sine, 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0))
    scale = angle / sine if sine > 1e-9 else 1.0
    return scale * x, scale * y, scale * z
