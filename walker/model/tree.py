"""Forward kinematics of every link, from the data sheet's tree of joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bridge.body import TORSO, Body, joint_tree
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.types import Array
from walker.model.transforms import Transform, homogeneous


class BodyTree:
    """The links of a body, placed by the 25 joint positions of a frame.

    All joints of one depth are turned in one numpy operation: a joint at a time would cost five times as much.

    Args:
        body: The data sheet.
    """

    links: tuple[str, ...]
    """The Torso, then the joints whose links follow, parents before children."""

    def __init__(self, body: Body) -> None:
        tree = joint_tree(body)
        depth = {TORSO: 0}
        for name, joint in tree.items():
            depth[name] = depth[joint.parent] + 1
        self.links = tuple(sorted(depth, key=depth.__getitem__))
        place = {name: i for i, name in enumerate(self.links)}
        joints = [tree[name] for name in self.links[1:]]
        self._slots = np.array([INDEX_WITH_MIRROR[name] for name in self.links[1:]])
        # Rodrigues: R = E + sin q K + (1 - cos q) K K, with the axis' cross product matrix K.
        self._sine = np.zeros((len(joints), 4, 4))
        self._sine[:, :3, :3] = [np.cross(np.eye(3), joint.axis) for joint in joints]
        self._versine = self._sine @ self._sine
        self._torso = np.eye(4)
        self._still = np.array([homogeneous(np.eye(3), joint.offset) for joint in joints])
        parents = np.array([place[joint.parent] for joint in joints])
        depths = np.array([depth[name] for name in self.links[1:]])
        # By depth from 2 on: rows of the joints among `links`, and of their parents.
        self._levels = [
            (slice(first + 1, last + 1), parents[first:last])
            for first, last in (
                np.searchsorted(depths, [level, level + 1]).tolist() for level in range(2, depths.max() + 1)
            )
        ]

    def frames(self, position: Sequence[float] | Array) -> Array:
        """Frames of all links in the Torso frame, shape (links, 4, 4), m, in the order of `links`.

        Args:
            position: The 25 joint positions of a frame, rad. RHipYawPitch is at LHipYawPitch's slot; slots of
                joints that the body lacks are not read.
        """
        q = np.asarray(position, dtype=np.float64)[self._slots, None, None]
        frames = np.empty((len(self.links), 4, 4))
        frames[0] = self._torso
        frames[1:] = self._still + np.sin(q) * self._sine + (1.0 - np.cos(q)) * self._versine
        for rows, parents in self._levels:
            frames[rows] = frames[parents] @ frames[rows]
        return frames

    def link_frames(self, position: Sequence[float] | Array) -> dict[str, Transform]:
        """The same by the name of the joint that moves the link (`Torso` for the trunk), each (4, 4)."""
        return dict(zip(self.links, self.frames(position), strict=True))
