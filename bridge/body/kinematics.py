"""Forward kinematics of a body: legs, all links, centre of mass, and a torso at a pose in the world.

A leg is the chain of transforms of the thesis (Prenner 2011, 2.9 to 2.18), multiplied out. Its frames: 0 leg,
3 HipYawPitch, 4 HipRoll, 5 HipPitch, 6 KneePitch, 7 AnklePitch, 8 AnkleRoll (body frame of the foot), 9 sole
below the ankle, FM middle of the sole. Frames 1 and 2 hold the slanted HipYawPitch axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from bridge.body.joints import INDEX_WITH_MIRROR, LEG_SLOTS, TORSO, joint_tree
from bridge.body.model import Body
from bridge.body.quantities import total_mass
from bridge.body.sole import foot_centre, sole_hull
from bridge.rotations import quaternion, rotation
from bridge.types import SIDES, Array, Matrix3, Quaternion, Side, Vec2, Vec3

Transform = Array
"""A homogeneous transform, shape (4, 4), lengths in m."""


def homogeneous(R: Array, d: Sequence[float] | Array) -> Transform:
    """The transform with a rotation and an origin, shape (4, 4) (2.7).

    Args:
        R: rotation, shape (3, 3).
        d: origin, shape (3,), m.
    """
    H = np.zeros((4, 4))
    H[:3, :3] = R
    H[:3, 3] = d
    H[3, 3] = 1.0
    return H


def inverse(H: Transform) -> Transform:
    """The inverse of a transform, shape (4, 4)."""
    return homogeneous(H[:3, :3].T, -H[:3, :3].T @ H[:3, 3])


def translation(x: float, y: float, z: float) -> Transform:
    """The transform that only shifts, m (2.7 with R = E)."""
    return np.array([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


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


def hip_in_torso(body: Body, side: Side) -> Vec3:
    """Point in which the three hip axes of a leg meet (frame 0), in the Torso frame, m.

    Args:
        body: The data sheet.
        side: The leg.
    """
    return 0.0, side_sign(side) * body.lengths.HipOffsetY, -body.lengths.HipOffsetZ


def foot_in_torso(body: Body, side: Side, angles: Sequence[float]) -> Transform:
    """Pose of the foot (frame 8, AnkleRoll) in the Torso frame, shape (4, 4), m.

    Args:
        body: The data sheet.
        side: The leg.
        angles: HipYawPitch, HipRoll, HipPitch, KneePitch, AnklePitch, AnkleRoll, rad.
    """
    phi_2, psi_4, theta_5, theta_6, theta_7, psi_8 = angles
    length = body.lengths
    knee = theta_5 + theta_6
    x = -length.ThighLength * math.sin(theta_5) - length.TibiaLength * math.sin(knee)
    z = -length.ThighLength * math.cos(theta_5) - length.TibiaLength * math.cos(knee)
    s4, c4 = math.sin(psi_4), math.cos(psi_4)
    s7, c7 = math.sin(knee + theta_7), math.cos(knee + theta_7)
    s8, c8 = math.sin(psi_8), math.cos(psi_8)
    rows = []
    for (r0, r1, r2), d in zip(hip_rotation(side, phi_2), hip_in_torso(body, side), strict=True):
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


class CentreOfMass:
    """Centre of mass in the Torso frame, from the mass table through the forward kinematics.

    Args:
        body: The data sheet.
    """

    tree: BodyTree
    """Its forward kinematics."""
    mass: float
    """Mass of the whole robot, kg."""

    def __init__(self, body: Body) -> None:
        self.tree = BodyTree(body)
        links = [body.links[name] for name in self.tree.links]
        self.mass = total_mass(body)
        # Sum of m (R c + p) / M is the frames applied to (m c / M, m / M).
        self._weights = np.array([(*link.com, 1.0) for link in links])
        self._weights *= np.array([[link.mass] for link in links]) / self.mass

    def __call__(self, position: Sequence[float] | Array) -> Array:
        """The centre of mass in the Torso frame, shape (3,), m.

        Args:
            position: The 25 joint positions of a frame, rad.
        """
        return self.of_frames(self.tree.frames(position))

    def of_frames(self, frames: Array) -> Array:
        """The same for link frames that are known already.

        Args:
            frames: `tree.frames(...)`; in another frame than the Torso's the result is in that frame too.
        """
        com: Array = np.einsum("nij,nj->i", frames[:, :3], self._weights)
        return com


@dataclass(frozen=True)
class RobotPose:
    """A robot in the world, z up, m."""

    frames: Array
    """Frames of all links, shape (links, 4, 4), in the order of `FloatingBase.links`."""
    feet: dict[Side, Transform]
    """AnkleRoll frames."""
    mass: CentreOfMass
    """Centre of mass of the body."""

    @cached_property
    def com(self) -> Array:
        """Centre of mass, shape (3,)."""
        return self.mass.of_frames(self.frames)


class FloatingBase:
    """Forward kinematics of all links of a body in the world.

    Args:
        body: The data sheet.
    """

    def __init__(self, body: Body) -> None:
        self.body = body
        """The data sheet."""
        self._mass = CentreOfMass(body)
        self._newest: tuple[tuple[float, ...], Array] | None = None
        """Joint angles of the last call of `in_torso`, and their link frames."""
        self.links = self._mass.tree.links
        """The Torso, then the joints whose links follow."""
        self._feet = {side: self.links.index(f"{side}AnkleRoll") for side in SIDES}
        self.soles: dict[Side, Array] = {}
        """Corners of each sole's bottom, homogeneous, AnkleRoll frame, shape (n, 4), m."""
        for side in SIDES:
            hull = sole_hull(body, side)
            low = np.full(len(hull), -body.lengths.FootHeight)
            self.soles[side] = np.column_stack([hull, low, np.ones(len(hull))])
        self.centres: dict[Side, Array] = {
            side: np.array([*foot_centre(body, side), -body.lengths.FootHeight, 1.0]) for side in SIDES
        }
        """Middle of each sole (FM), as `soles`, shape (4,)."""

    def in_torso(self, position: Sequence[float]) -> Array:
        """Link frames in the Torso frame, computed once per cycle.

        Args:
            position: the 25 joint angles of a frame, rad.

        Returns:
            Shape (links, 4, 4), m; not to be written to.
        """
        angles = tuple(position)
        if self._newest is None or self._newest[0] != angles:
            self._newest = angles, self._mass.tree.frames(angles)
        return self._newest[1]

    def foot(self, in_torso: Array, side: Side) -> Transform:
        """Pose of one AnkleRoll frame in the Torso frame, shape (4, 4), m.

        Args:
            in_torso: link frames as `in_torso` gives them.
            side: of the foot.
        """
        frame: Transform = in_torso[self._feet[side]]
        return frame

    def place(self, in_torso: Array, torso: Transform) -> RobotPose:
        """The robot with its torso at a pose in the world.

        Args:
            in_torso: link frames as `in_torso` gives them.
            torso: pose of the Torso frame in the world, shape (4, 4), m.
        """
        frames = torso @ in_torso
        feet = {side: frames[i] for side, i in self._feet.items()}
        return RobotPose(frames, feet, self._mass)

    def sole_in_world(self, side: Side, foot: Transform) -> Array:
        """Corners of a sole, shape (n, 3), m.

        Args:
            side: of the foot.
            foot: pose of its AnkleRoll frame in the world, shape (4, 4), m.
        """
        corners: Array = (self.soles[side] @ foot.T)[:, :3]
        return corners


class LinkTransform(NamedTuple):
    """A child's frame in its parent's."""

    parent: str
    child: str
    translation: Vec3
    """Offset from the parent's frame, m."""
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

    def of_joints(self, position: Sequence[float]) -> list[LinkTransform]:
        """Each link in its parent's frame.

        Args:
            position: the 25 joint positions of a frame, rad.
        """
        matches = []
        for name, joint in self._tree.items():
            half = 0.5 * position[INDEX_WITH_MIRROR[name]]
            (x, y, z), sine = joint.axis, math.sin(half)
            turn = (x * sine, y * sine, z * sine, math.cos(half))
            matches.append(LinkTransform(joint.parent, name, joint.offset, turn))
        return matches

    def torso_over_feet(self, parent: str, position: Sequence[float], angle: Vec2) -> LinkTransform:
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
        return LinkTransform(parent, TORSO, (x, y, height), quaternion(turn))

    def _sole_in_torso(self, side: Side, position: Sequence[float]) -> Array:
        return sole_in_torso(self._body, side, [position[slot] for slot in LEG_SLOTS[side]])[:3, 3]
