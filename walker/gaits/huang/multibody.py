"""The zero moment point of all bodies, rotation included ((13), (14)).

From the balance of moments about the point:

    x_zmp = (sum m (z'' + g) x - sum m x'' z - sum L'_y) / sum m (z'' + g)
    y_zmp = (sum m (z'' + g) y - sum m y'' z + sum L'_x) / sum m (z'' + g)

In right-handed axes the rotation term of (14) has the other sign than printed. L' is the whole rate of a body's
angular momentum about its own centre of mass, I alpha + omega x I omega with the tensor of the data sheet
turned along; the source has I_y alpha_y alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from bridge.body import Body
from bridge.body.inverse_kinematics import FootPose, solve_legs
from bridge.body.joints import INDEX, LEG_SLOTS, N_JOINTS
from bridge.body.kinematics import BodyTree
from bridge.body.quantities import GRAVITY, tensor_matrix
from bridge.rotations import rotation_rows
from bridge.types import Array, Vec3

STEP: Final = 1e-3
"""s; of the differences in time."""


class Ankle(NamedTuple):
    """Ankle of a foot that points along x."""

    x: float
    y: float
    z: float
    pitch: float


class Bodies:
    """All bodies of a robot whose torso is upright and whose arms hang still.

    Args:
        body: data sheet.
        arms: joint angles of arms and head that are not zero, rad.
    """

    def __init__(self, body: Body, arms: dict[str, float]) -> None:
        self._body = body
        self._tree = BodyTree(body)
        self.links = self._tree.links
        """Their names, in the order of all frames."""
        links = [body.links[name] for name in self.links]
        self.mass = np.array([link.mass for link in links])
        self._centre = np.array([link.com for link in links])
        self._inertia = np.array([tensor_matrix(link.inertia) for link in links])
        self._hip = body.lengths.HipOffsetZ
        self._angles = [0.0] * N_JOINTS
        for joint, angle in arms.items():
            self._angles[INDEX[joint]] = angle

    def joint_angles(self, hip: tuple[float, float, float], left: Ankle, right: Ankle) -> list[float]:
        """25 joint angles, rad, their ranges left aside.

        Args:
            hip: middle between the hip joints, walk frame, m.
            left: foot.
            right: foot.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        torso = (hip[0], hip[1], hip[2] + self._hip)
        legs = solve_legs(self._body, _pose(left, torso), _pose(right, torso))
        angles = list(self._angles)
        for slots, solved in ((LEG_SLOTS["L"], legs.left), (LEG_SLOTS["R"], legs.right)):
            for slot, angle in zip(slots, solved, strict=True):
                angles[slot] = angle
        return angles

    def frames(self, hip: tuple[float, float, float], left: Ankle, right: Ankle) -> Array:
        """Frames of all bodies in the walk frame, shape (bodies, 4, 4), m.

        Raises:
            UnreachableError: a foot is out of the leg's reach.
        """
        frames = self._tree.frames(self.joint_angles(hip, left, right))
        frames[:, :3, 3] += (hip[0], hip[1], hip[2] + self._hip)
        return frames

    def centre_of_mass(self, frames: Array) -> Array:
        """Centre of mass of all bodies, shape (3,), m."""
        com: Array = self.mass @ self.centres(frames) / self.mass.sum()
        return com

    def centres(self, frames: Array) -> Array:
        """Centres of mass of frames of any leading shape, (..., bodies, 3), m."""
        places: Array = np.einsum("...ij,...j->...i", frames[..., :3, :3], self._centre) + frames[..., :3, 3]
        return places

    def zmp(self, before: Array, now: Array, after: Array, step: float = STEP) -> tuple[float, float]:
        """Zero moment point on z = 0 from three neighbouring moments, m.

        Args:
            before: frames `step` seconds earlier.
            now: frames.
            after: frames `step` seconds later.
            step: s.
        """
        first, second = (after - before) / (2.0 * step), (after - 2.0 * now + before) / step**2
        x, y, weight = self.moments(now, [second], [first])[:, 0]
        return float(x / weight), float(y / weight)

    def moments(self, frames: Array, second: Sequence[Array], first: Sequence[Array]) -> Array:
        """Numerators of (13), (14) and their denominator, as polynomials in the rate of one coordinate u.

        Args:
            frames: shape (..., bodies, 4, 4).
            second: coefficients of 1, u', u'^2 and u'' in the frames' second derivative in time, or the first
                of these alone; each of the frames' shape.
            first: coefficients of 1 and u' in their first one, or the former alone.

        Returns:
            Shape (3, len(second), ...): for x, y and weight the factors of 1, u', u'^2, u''.
        """
        rotation = frames[..., :3, :3]
        inertia = rotation @ self._inertia @ np.swapaxes(rotation, -1, -2)
        omega = [_vee(rate[..., :3, :3], rotation) for rate in first]
        spin = [_times(inertia, w) for w in omega]
        gyroscopic = [np.cross(omega[0], spin[0])]
        if len(first) > 1:
            gyroscopic.append(np.cross(omega[0], spin[1]) + np.cross(omega[1], spin[0]))
            gyroscopic.append(np.cross(omega[1], spin[1]))
        place = self.centres(frames)
        rows = []
        for i, part in enumerate(second):
            a = np.einsum("...ij,...j->...i", part[..., :3, :3], self._centre) + part[..., :3, 3]
            if i == 0:
                a = a + np.array([0.0, 0.0, GRAVITY])
            rate = _times(inertia, _vee(part[..., :3, :3], rotation))
            if i < len(gyroscopic):
                rate = rate + gyroscopic[i]
            x = (a[..., 2] * place[..., 0] - a[..., 0] * place[..., 2]) @ self.mass - rate[..., 1].sum(-1)
            y = (a[..., 2] * place[..., 1] - a[..., 1] * place[..., 2]) @ self.mass + rate[..., 0].sum(-1)
            rows.append((x, y, a[..., 2] @ self.mass))
        return np.swapaxes(np.array(rows), 0, 1)


def _pose(foot: Ankle, torso: Vec3) -> FootPose:
    place = foot.x - torso[0], foot.y - torso[1], foot.z - torso[2]
    return FootPose(place, rotation_rows(0.0, foot.pitch, 0.0))


def _vee(rate: Array, rotation: Array) -> Array:
    """Vector of the skew part of rate R^T: angular velocity of R', angular acceleration of R''."""
    m = rate @ np.swapaxes(rotation, -1, -2)
    return 0.5 * np.stack(
        (m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]), axis=-1
    )


def _times(matrix: Array, vector: Array) -> Array:
    product: Array = np.einsum("...ij,...j->...i", matrix, vector)
    return product
