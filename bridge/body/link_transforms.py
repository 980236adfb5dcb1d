"""Where each link is in its parent's frame, and the torso over the feet: the transforms of viewers and ROS."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from bridge.body.joints import INDEX_WITH_MIRROR, LEG_SLOTS, TORSO, joint_tree
from bridge.body.kinematics import sole_in_torso
from bridge.body.model import Body
from bridge.rotations import quaternion, rotation
from bridge.types import SIDES, Array, Quaternion, Side, Vec2, Vec3


class Transform(NamedTuple):
    """A child's frame in its parent's."""

    parent: str
    child: str
    translation: Vec3
    """m"""
    rotation: Quaternion
    """x, y, z, w"""


class LinkTransforms:
    """Transforms of one body's links, named as in the exported URDF: the torso, and each joint's link.

    Args:
        body: data sheet.
    """

    def __init__(self, body: Body) -> None:
        self._tree = joint_tree(body)
        self._body = body

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints with a link, parents before children; both HipYawPitch are among them."""
        return tuple(self._tree)

    def of_joints(self, position: Sequence[float]) -> list[Transform]:
        """Each link in its parent's frame.

        Args:
            position: the 25 joint positions of a frame, rad.
        """
        found = []
        for name, joint in self._tree.items():
            half = 0.5 * position[INDEX_WITH_MIRROR[name]]
            (x, y, z), sine = joint.axis, math.sin(half)
            turn = (x * sine, y * sine, z * sine, math.cos(half))
            found.append(Transform(joint.parent, name, joint.offset, turn))
        return found

    def torso_over_feet(self, parent: str, position: Sequence[float], angle: Vec2) -> Transform:
        """The torso in a frame on the ground below the middle of the soles that has its heading.

        The lower sole touches the ground.

        Args:
            parent: name of that frame.
            position: the 25 joint positions of a frame, rad.
            angle: roll and pitch of the torso, rad.
        """
        turn = rotation(angle[0], angle[1], 0.0)
        left, right = (turn @ self._sole_in_torso(side, position) for side in SIDES)
        x, y, _ = (-0.5 * (left + right)).tolist()
        height = -min(float(left[2]), float(right[2]))
        return Transform(parent, TORSO, (x, y, height), quaternion(turn))

    def _sole_in_torso(self, side: Side, position: Sequence[float]) -> Array:
        return sole_in_torso(self._body, side, [position[slot] for slot in LEG_SLOTS[side]])[:3, 3]
