"""Contact forces on the robot from PyBullet's contact points."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from bridge.body import TORSO
from bridge.types import SIDES, Vec3
from emulator.engine.contacts import STEEP, ground_contacts
from emulator.engine.pybullet.client import bullet
from emulator.engine.pybullet.model import BASE, BulletModel
from emulator.engine.values import GroundContacts
from emulator.poses import matrix


class BulletContacts:
    """Collects the contacts of a robot step by step.

    Args:
        model: The robot.
    """

    def __init__(self, model: BulletModel) -> None:
        self._model = model
        self._reactions = [_FootReaction() for _ in SIDES]
        self._feet = {
            links[side]: foot
            for links in (model.feet, model.pads)
            for side, foot in zip(SIDES, self._reactions, strict=True)
        }
        """By PyBullet's number of the link."""
        self._names = {BASE: TORSO} | dict(zip(model.numbers, model.joints, strict=True))
        self._others: set[tuple[int, int]] = set()
        """PyBullet's numbers of a body and of the robot's link that touched it."""
        self._steps = 0

    def _frames(self) -> list[tuple[float, ...]]:
        """The AnkleRoll frames now: origins and rotation matrices."""
        poses = [self._model.link_frame(self._model.feet[side]) for side in SIDES]
        return [(*pose.position, *matrix(pose.orientation)) for pose in poses]

    def begin(self) -> None:
        """Forget the last cycle; the soles' normals are those of now until `mean`."""
        for foot, frame in zip(self._reactions, self._frames(), strict=True):
            foot.begin((frame[5], frame[8], frame[11]))
        self._others.clear()
        self._steps = 0

    def take_step(self) -> None:
        """Take in the contacts of the physics step just done."""
        feet = self._feet
        for point in bullet.getContactPoints(self._model.robot, physicsClientId=self._model.client):
            foot = feet.get(point[3])
            if foot is not None:
                # force on the robot: along the normal n, and friction along a and b
                n, a, b = point[7], point[11], point[13]
                fn, fa, fb = point[9], point[10], point[12]
                foot.take(
                    n[0] * fn + a[0] * fa + b[0] * fb,
                    n[1] * fn + a[1] * fa + b[1] * fb,
                    n[2] * fn + a[2] * fa + b[2] * fb,
                    point[5],
                    n,
                    fn,
                )
            elif point[8] <= 0.0:
                self._others.add((point[2], point[3]))
        self._steps += 1

    def mean(self, ground: Collection[int], normal: Vec3) -> GroundContacts:
        """Means since `begin`.

        Args:
            ground: PyBullet's numbers of all that counts as ground.
            normal: Of the floor, world frame.
        """
        touching = frozenset(self._names[link] for body, link in self._others if body in ground)
        sums = np.array([foot.sums for foot in self._reactions])
        rim = [(i, place) for i, foot in enumerate(self._reactions) for place in foot.rim]
        return ground_contacts(sums, rim, np.array(self._frames()), max(self._steps, 1), normal, touching)


class _FootReaction:
    """Sums over the contact points and steps of a cycle for one foot."""

    def __init__(self) -> None:
        self.begin((0.0, 0.0, 1.0))

    def begin(self, normal: Vec3) -> None:
        """Forget all contacts; the sole's normal in the world is this from now on."""
        self._sole = normal
        self._fx = self._fy = self._fz = 0.0
        self._normal = self._px = self._py = self._pz = 0.0
        self.rim: list[Vec3] = []
        """Places of the contacts on the rim, world frame, m."""

    @property
    def sums(self) -> tuple[float, ...]:
        """For `ground_contacts`."""
        return self._fx, self._fy, self._fz, self._normal, self._px, self._py, self._pz

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
        n = self._sole
        # The force along the sole's normal is the weight of the place in the centre of pressure.
        weight = n[0] * x + n[1] * y + n[2] * z
        self._fx += x
        self._fy += y
        self._fz += z
        self._normal += weight
        self._px += weight * place[0]
        self._py += weight * place[1]
        self._pz += weight * place[2]
        if normal_force > 0.0 and abs(n[0] * normal[0] + n[1] * normal[1] + n[2] * normal[2]) < STEEP:
            self.rim.append(place)
