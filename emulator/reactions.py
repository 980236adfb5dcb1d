"""Ground reactions from PyBullet's contact points, averaged over the physics steps of a cycle.

A servo that gets a new request every cycle makes the contact forces swing within the cycle, by tens of
newtons when it is stiff. A sample of the last step would be wrong in the mean, the centre of pressure by
centimetres; force sensors have filters that see the average.
"""

from __future__ import annotations

from typing import Any, Final

from bridge.datasheet.model import Side
from bridge.messages import Vec2, Vec3
from emulator.contacts import FootLoad, Ground, GroundContacts
from emulator.engine import bullet
from emulator.model import RobotModel
from emulator.vectors import Rotation, add, rotate_back, scaled

TOE: Final = 0.06
"""Bumpers cover what lies farther forward on the foot, m (assumed; they sit at 0.0876)."""
BUMPER_MIDDLE: Final[dict[Side, float]] = {"L": 0.0025, "R": -0.0025}
"""y between the left and the right bumper of a foot, AnkleRoll frame, m (data sheet: 0.019 and -0.014)."""
STEEP: Final = 0.5
"""Cosine to the sole's normal below which a contact pushes on the rim of the foot, not on the sole."""


class _Foot:
    """Sums over the points and steps of a cycle for one foot."""

    def __init__(self, side: Side, link: int) -> None:
        self.side, self.link = side, link
        self.origin: Vec3 = (0.0, 0.0, 0.0)
        self.rotation: Rotation = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        self.clear()

    def clear(self) -> None:
        self.fx = self.fy = self.fz = 0.0
        self.normal = self.px = self.py = self.pz = 0.0
        self.rim: list[Vec3] = []

    def take(self, point: Any) -> None:
        """One contact point: force on the robot is a normal and two friction parts."""
        n, a, b = point[7], point[11], point[13]
        fn, fa, fb = point[9], point[10], point[12]
        x = n[0] * fn + a[0] * fa + b[0] * fb
        y = n[1] * fn + a[1] * fa + b[1] * fb
        z = n[2] * fn + a[2] * fa + b[2] * fb
        m, place = self.rotation, point[5]
        share = m[2] * x + m[5] * y + m[8] * z
        self.fx += x
        self.fy += y
        self.fz += z
        self.normal += share
        self.px += share * place[0]
        self.py += share * place[1]
        self.pz += share * place[2]
        if fn > 0.0 and abs(m[2] * n[0] + m[5] * n[1] + m[8] * n[2]) < STEEP:
            self.rim.append(place)

    @property
    def cop(self) -> Vec3 | None:
        """World frame, m."""
        if self.normal <= 0.0:
            return None
        return self.px / self.normal, self.py / self.normal, self.pz / self.normal

    def local(self, place: Vec3) -> Vec3:
        """A place of the world in the AnkleRoll frame."""
        return rotate_back(self.rotation, add(place, scaled(self.origin, -1.0)))


class GroundReactions:
    """Collects the contacts of a robot step by step.

    Args:
        model: The robot.
    """

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._feet = [_Foot(side, link) for side, link in model.feet.items()]
        self._by_link = {foot.link: foot for foot in self._feet}
        self._bodies: set[int] = set()
        self._steps = 0

    def _place_feet(self) -> None:
        for foot in self._feet:
            state = bullet.getLinkState(
                self._model.robot, foot.link, computeForwardKinematics=True, physicsClientId=self._model.client
            )
            foot.origin, foot.rotation = state[4], bullet.getMatrixFromQuaternion(state[5])

    def begin_cycle(self) -> None:
        """Forget the last cycle."""
        self._place_feet()
        for foot in self._feet:
            foot.clear()
        self._bodies.clear()
        self._steps = 0

    def take_step(self) -> None:
        """Take in the contacts of the physics step just done; the soles' normals are those at `begin_cycle`."""
        for point in bullet.getContactPoints(self._model.robot, physicsClientId=self._model.client):
            foot = self._by_link.get(point[3])
            if foot is not None:
                foot.take(point)
            elif point[8] <= 0.0:
                self._bodies.add(point[2])
        self._steps += 1

    def mean(self, ground: Ground) -> GroundContacts:
        """Mean forces since `begin_cycle`, centres of pressure weighted by force."""
        self._place_feet()
        steps = max(self._steps, 1)
        feet: dict[Side, FootLoad] = {}
        bumped: set[str] = set()
        total = x = y = 0.0
        for foot in self._feet:
            force = scaled((foot.fx, foot.fy, foot.fz), 1.0 / steps)
            cop = foot.cop
            place: Vec2 | None = None
            if cop is not None:
                place = foot.local(cop)[:2]
                load = sum(f * n for f, n in zip(force, ground.normal, strict=True))
                total, x, y = total + load, x + load * cop[0], y + load * cop[1]
            feet[foot.side] = FootLoad(force, foot.normal / steps, place)
            bumped |= _bumped(foot)
        zmp = (x / total, y / total) if total > 0.0 else None
        return GroundContacts(feet, zmp, not self._bodies.isdisjoint(ground.bodies), frozenset(bumped))


def _bumped(foot: _Foot) -> set[str]:
    """Bumpers of a foot that something pushes."""
    name = "left" if foot.side == "L" else "right"
    toes = [foot.local(place) for place in foot.rim]
    sides = {"left" if toe[1] > BUMPER_MIDDLE[foot.side] else "right" for toe in toes if toe[0] > TOE}
    return {f"{name}_bumper_{side}" for side in sides}
