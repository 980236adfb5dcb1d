"""Ground reactions from PyBullet's contact points: per foot, and of anything else that touches the world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from bridge.datasheet.model import Side
from bridge.messages import Vec2, Vec3
from emulator.engine import bullet
from emulator.model import RobotModel


class Ground(Protocol):
    """What a robot stands on."""

    bodies: set[int]
    """PyBullet's numbers of the floor and of everything fixed on it."""
    normal: Vec3
    """Of the floor, world frame, upward."""


@dataclass(frozen=True)
class FootLoad:
    """What the ground does to one foot."""

    force: Vec3
    """Sum of the contact forces, world frame, N."""
    normal_force: float
    """Part of it along the sole's normal, N."""
    cop: Vec2 | None
    """Centre of pressure in the sole frame (below the AnkleRoll origin), m; None without load."""


@dataclass(frozen=True)
class GroundContacts:
    """All contacts of the robot with the world after one physics step."""

    feet: dict[Side, FootLoad]
    zmp: Vec2 | None
    """Centre of pressure of both feet together, world frame x and y, m; None without load. Points count by
    their force along the floor's normal, so that it is the true one on a tilted floor too."""
    fallen: bool
    """Something other than a foot touches the ground."""
    bumped: frozenset[str] = frozenset()
    """Bumpers that something pushes, by their names in `emulator.sensors.touch`."""


def ground_contacts(model: RobotModel, ground: Ground) -> GroundContacts:
    """Contacts of the last physics step."""
    points = bullet.getContactPoints(model.robot, physicsClientId=model.client)
    by_link: dict[int, list[Any]] = {link: [] for link in model.feet.values()}
    fallen = False
    for point in points:
        if point[3] in by_link:
            by_link[point[3]].append(point)
        elif point[8] <= 0.0 and point[2] in ground.bodies:
            fallen = True
    feet = {side: _foot_load(model, link, by_link[link]) for side, link in model.feet.items()}
    zmp = _zmp([p for points in by_link.values() for p in points], ground.normal)
    return GroundContacts(feet, zmp, fallen)


def _force(point: Any) -> Vec3:
    """Force of one contact on the robot, world frame, N: normal and two friction parts."""
    n, a, b = point[7], point[11], point[13]
    fn, fa, fb = point[9], point[10], point[12]
    return (
        n[0] * fn + a[0] * fa + b[0] * fb,
        n[1] * fn + a[1] * fa + b[1] * fb,
        n[2] * fn + a[2] * fa + b[2] * fb,
    )


def _foot_load(model: RobotModel, link: int, points: list[Any]) -> FootLoad:
    if not points:
        return FootLoad((0.0, 0.0, 0.0), 0.0, None)
    state = bullet.getLinkState(model.robot, link, computeForwardKinematics=True, physicsClientId=model.client)
    origin = state[4]
    m = bullet.getMatrixFromQuaternion(state[5])
    fx = fy = fz = normal = moment_x = moment_y = 0.0
    for point in points:
        force, place = _force(point), point[5]
        dx, dy, dz = place[0] - origin[0], place[1] - origin[1], place[2] - origin[2]
        share = m[2] * force[0] + m[5] * force[1] + m[8] * force[2]
        fx, fy, fz = fx + force[0], fy + force[1], fz + force[2]
        normal += share
        moment_x += share * (m[0] * dx + m[3] * dy + m[6] * dz)
        moment_y += share * (m[1] * dx + m[4] * dy + m[7] * dz)
    cop = (moment_x / normal, moment_y / normal) if normal > 0.0 else None
    return FootLoad((fx, fy, fz), normal, cop)


def _zmp(points: list[Any], normal: Vec3) -> Vec2 | None:
    total = x = y = 0.0
    for point in points:
        force = _force(point)
        load = force[0] * normal[0] + force[1] * normal[1] + force[2] * normal[2]
        total += load
        x += load * point[6][0]
        y += load * point[6][1]
    return (x / total, y / total) if total > 0.0 else None
