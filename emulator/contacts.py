"""What is known about the contacts of a robot with the world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from bridge.datasheet.model import Side
from bridge.messages import Vec2, Vec3


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
    """All contacts of the robot with the world, forces as means over a cycle."""

    feet: dict[Side, FootLoad]
    zmp: Vec2 | None
    """Centre of pressure of both feet together, world frame x and y, m; None without load. Feet count by their
    force along the floor's normal, so that it is the true one on a tilted floor too."""
    fallen: bool
    """Something other than a foot touches the ground."""
    bumped: frozenset[str] = frozenset()
    """Bumpers that something pushes, by their names in `emulator.sensors.touch`."""
