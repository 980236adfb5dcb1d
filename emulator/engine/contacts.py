"""Means of the contact forces on the feet over the physics steps of a cycle.

A servo that gets a new request every cycle makes the contact forces swing within the cycle, by tens of newtons
when it is stiff. A sample of the last step would be wrong in the mean, the centre of pressure by centimetres;
force sensors have filters that see the average.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from bridge.types import Side, Vec2, Vec3
from emulator.engine.values import FootLoad, GroundContacts
from emulator.poses import ORIGIN, Pose, matrix
from emulator.vectors import Rotation, add, rotate_back, scaled

STEEP: Final = 0.5
"""Cosine to the sole's normal below which a contact pushes on the rim of the foot, not on the sole."""


class FootReaction:
    """Sums over the contact points and steps of a cycle for one foot.

    Args:
        side: Of the foot.
    """

    def __init__(self, side: Side) -> None:
        self.side: Side = side
        self.place(ORIGIN)
        self.clear()

    def place(self, pose: Pose) -> None:
        """Take over the pose of the AnkleRoll frame in the world."""
        self._origin = pose.position
        self._rotation: Rotation = matrix(pose.orientation)

    def clear(self) -> None:
        """Forget all contacts."""
        self._fx = self._fy = self._fz = 0.0
        self._normal = self._px = self._py = self._pz = 0.0
        self._rim: list[Vec3] = []

    def take(self, x: float, y: float, z: float, place: Vec3, normal: Vec3, normal_force: float) -> None:
        """Add the force of one contact point in one physics step.

        Args:
            x: Of the force on the foot, world frame, N.
            y: Likewise.
            z: Likewise.
            place: Of the contact, world frame, m.
            normal: Of the contact, world frame.
            normal_force: Part of the force along it, N.
        """
        m = self._rotation
        # The force along the sole's normal, third column of the rotation, is the weight of the place in the
        # centre of pressure.
        weight = m[2] * x + m[5] * y + m[8] * z
        self._fx += x
        self._fy += y
        self._fz += z
        self._normal += weight
        self._px += weight * place[0]
        self._py += weight * place[1]
        self._pz += weight * place[2]
        if normal_force > 0.0 and abs(m[2] * normal[0] + m[5] * normal[1] + m[8] * normal[2]) < STEEP:
            self._rim.append(place)

    @property
    def cop(self) -> Vec3 | None:
        """Centre of pressure, world frame, m; None without load."""
        if self._normal <= 0.0:
            return None
        return self._px / self._normal, self._py / self._normal, self._pz / self._normal

    def _local(self, place: Vec3) -> Vec3:
        """A place of the world in the AnkleRoll frame."""
        return rotate_back(self._rotation, add(place, scaled(self._origin, -1.0)))

    def mean(self, steps: int) -> FootLoad:
        """The load as a mean over so many steps, in the foot's present pose."""
        force = scaled((self._fx, self._fy, self._fz), 1.0 / steps)
        cop = self.cop
        place = None if cop is None else self._local(cop)[:2]
        return FootLoad(force, self._normal / steps, place, tuple(map(self._local, self._rim)))


def ground_contacts(
    feet: Iterable[FootReaction], steps: int, normal: Vec3, touching: frozenset[str]
) -> GroundContacts:
    """All contacts of a cycle.

    Args:
        feet: Both, in their present poses.
        steps: Of the cycle.
        normal: Of the floor, world frame.
        touching: Other links on the ground.
    """
    loads: dict[Side, FootLoad] = {}
    total = x = y = 0.0
    for foot in feet:
        loads[foot.side] = load = foot.mean(steps)
        cop = foot.cop
        if cop is not None:
            weight = sum(f * n for f, n in zip(load.force, normal, strict=True))
            total, x, y = total + weight, x + weight * cop[0], y + weight * cop[1]
    zmp: Vec2 | None = (x / total, y / total) if total > 0.0 else None
    return GroundContacts(loads, zmp, touching)
