"""Load of each joint of a robot with a held torso: gravity and inertia of all links behind it.

Other joints are taken where they are measured, and at rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bridge.body import Body, joint_tree
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.body.quantities import GRAVITY, tensor_matrix
from bridge.body.topology import TORSO
from nao_hil.identification.signals import Array


@dataclass(frozen=True)
class JointLoad:
    """Of one joint over time, (n,) each; its angle is q, the measured one q_m."""

    cosine: Array
    """Torque of gravity is cosine cos(q - q_m) + sine sin(q - q_m), N m."""
    sine: Array
    inertia: Array
    """About the axis, without the rotor, kg m^2."""


def joint_loads(body: Body, position: Array, angle: Array) -> dict[str, JointLoad]:
    """Loads of all mechanical joints.

    Args:
        body: Data sheet.
        position: Measured angles, (n, 25), rad.
        angle: Roll and pitch of the torso, (n, 2), rad; NaN: upright.
    """
    tree = joint_tree(body)
    turn, place = _poses(body, position)
    roll, pitch = np.nan_to_num(angle).T
    # gravity in the torso frame: R^T (0, 0, -g) with R = R_y(pitch) R_x(roll)
    down = np.stack([np.sin(pitch), -np.sin(roll) * np.cos(pitch), -np.cos(roll) * np.cos(pitch)], axis=1)
    parent = {name: tree[name].parent for name in tree}
    loads = {}
    for joint, node in tree.items():
        axis = turn[joint] @ np.asarray(node.axis)
        moment, inertia = np.zeros_like(down), np.zeros(len(down))
        for link in (name for name in tree if _carries(parent, joint, name)):
            sheet = body.links[link]
            arm = place[link] + turn[link] @ np.asarray(sheet.com) - place[joint]
            moment += sheet.mass * arm
            own = np.einsum("nji,nj->ni", turn[link], axis)
            inertia += np.einsum("ni,ij,nj->n", own, tensor_matrix(sheet.inertia), own)
            inertia += sheet.mass * np.square(np.cross(axis, arm)).sum(axis=1)
        loads[joint] = JointLoad(
            cosine=GRAVITY * np.einsum("ni,ni->n", axis, np.cross(moment, down)),
            sine=GRAVITY * np.einsum("ni,ni->n", axis, np.cross(np.cross(axis, moment), down)),
            inertia=inertia,
        )
    return loads


def _poses(body: Body, position: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Rotation (n, 3, 3) and origin (n, 3) of each joint's link in the torso frame."""
    count = len(position)
    turn: dict[str, Array] = {TORSO: np.broadcast_to(np.eye(3), (count, 3, 3))}
    place: dict[str, Array] = {TORSO: np.zeros((count, 3))}
    for joint, node in joint_tree(body).items():
        x, y, z = node.axis
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        q = position[:, INDEX_WITH_MIRROR[joint], None, None]
        own = np.eye(3) + np.sin(q) * cross + (1.0 - np.cos(q)) * (cross @ cross)
        place[joint] = place[node.parent] + turn[node.parent] @ np.asarray(node.offset)
        turn[joint] = turn[node.parent] @ own
    return turn, place


def _carries(parent: Mapping[str, str], joint: str, link: str) -> bool:
    """The link is behind the joint, or its own."""
    while link != TORSO:
        if link == joint:
            return True
        link = parent[link]
    return False
