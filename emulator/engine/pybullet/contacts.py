"""Contact forces on the robot from PyBullet's contact points."""

from __future__ import annotations

from collections.abc import Collection

from bridge.body import TORSO
from bridge.types import Vec3
from emulator.engine.contacts import FootReaction, ground_contacts
from emulator.engine.pybullet.client import bullet
from emulator.engine.pybullet.model import BASE, BulletModel
from emulator.engine.values import GroundContacts


class BulletContacts:
    """Collects the contacts of a robot step by step.

    Args:
        model: The robot.
    """

    def __init__(self, model: BulletModel) -> None:
        self._model = model
        self._reactions = {side: FootReaction(side) for side in model.feet}
        self._feet = {
            link: self._reactions[side] for links in (model.feet, model.pads) for side, link in links.items()
        }
        """By PyBullet's number of the link."""
        self._names = {BASE: TORSO} | dict(zip(model.numbers, model.joints, strict=True))
        self._others: set[tuple[int, int]] = set()
        """PyBullet's numbers of a body and of the robot's link that touched it."""
        self._steps = 0

    def _place_feet(self) -> None:
        for side, foot in self._reactions.items():
            foot.place(self._model.link_frame(self._model.feet[side]))

    def begin(self) -> None:
        """Forget the last cycle; the soles' normals are those of now until `mean`."""
        self._place_feet()
        for foot in self._reactions.values():
            foot.clear()
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
        self._place_feet()
        touching = {self._names[link] for body, link in self._others if body in ground}
        return ground_contacts(self._reactions.values(), max(self._steps, 1), normal, frozenset(touching))
