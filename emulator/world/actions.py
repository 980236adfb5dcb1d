"""Actions that change the world for a while, step by step: a turning floor, a push, a pendulum."""

from __future__ import annotations

import math
from typing import Final, Protocol

from bridge.types import Vec3
from emulator.engine.base import Engine, Multibody
from emulator.engine.values import Pendulum
from emulator.poses import Pose, quaternion
from emulator.world.world import World

BOB_RADIUS: Final = 0.05
"""Radius of a pendulum's bob, m."""


class Action(Protocol):
    """An act on the robot that lasts for a while."""

    def step(self) -> bool:
        """Act before a physics step; False when the action has ended."""
        ...


class FloorTilt:
    """A turn of the floor, smooth at both ends.

    Args:
        world: Whose floor turns.
        roll: At the end, rad.
        pitch: At the end, rad.
        pivot: Point of the world it turns about, m.
        steps: Physics steps it takes.
    """

    def __init__(self, world: World, roll: float, pitch: float, pivot: Vec3, steps: int) -> None:
        self._world, self._pivot = world, pivot
        self._from, self._to = world.tilt, (roll, pitch)
        self._steps, self._done = max(1, steps), 0

    def step(self) -> bool:
        """Turn on by one step: the floor is put where it is now, and the engine moves it on by its velocity."""
        angle = math.pi * self._done / self._steps
        progress = 0.5 - 0.5 * math.cos(angle)
        speed = 0.5 * math.sin(angle) * math.pi / (self._steps * self._world.engine.settings.step)
        turns = [b - a for a, b in zip(self._from, self._to, strict=True)]
        roll, pitch = (a + progress * turn for a, turn in zip(self._from, turns, strict=True))
        self._world.set_tilt(roll, pitch, self._pivot, (speed * turns[0], speed * turns[1]))
        self._done += 1
        return self._done <= self._steps


class LinkPush:
    """A constant force at a link's centre of mass.

    Args:
        robot: Whose link.
        link: `Torso` or a joint.
        force: World frame, N.
        steps: Physics steps it lasts.
    """

    def __init__(self, robot: Multibody, link: str, force: Vec3, steps: int) -> None:
        self._robot, self._link, self._force, self._left = robot, link, force, steps

    def step(self) -> bool:
        """Push for one step."""
        self._robot.push(self._force, self._link)
        self._left -= 1
        return self._left > 0


class BoxPush:
    """A constant force at a movable box's centre of mass; ends when the box is taken away or replaced.

    Args:
        world: With the box.
        name: Of the box.
        force: World frame, N.
        steps: Physics steps it lasts.
    """

    def __init__(self, world: World, name: str, force: Vec3, steps: int) -> None:
        self._world, self._name, self._force, self._left = world, name, force, steps
        self._box = world.objects[name]

    def step(self) -> bool:
        """Push for one step."""
        if self._world.objects.get(self._name) is not self._box:
            return False
        self._box.thing.push(self._force)
        self._left -= 1
        return self._left > 0


class PendulumStrike:
    """A bob on a light rod, released at rest: strikes at its lowest point, removed after half a period.

    Args:
        engine: Where.
        bob: Middle of the bob when it hangs straight down, world frame, m.
        heading: Horizontal direction in which it moves there, from the world's x axis, rad.
        mass: Of the bob, kg.
        length: From the pivot to the middle of the bob, m.
        angle: At the release, from the vertical, rad.
    """

    def __init__(
        self, engine: Engine, bob: Vec3, heading: float, mass: float, length: float, angle: float
    ) -> None:
        self._engine = engine
        # The hinge's axis is y of a frame whose x axis is the direction of the strike.
        pivot = Pose((bob[0], bob[1], bob[2] + length), quaternion(yaw=heading))
        self.thing = engine.add(Pendulum(mass, length, BOB_RADIUS, angle), pivot)
        # period of a pendulum, to second order in the angle
        half_period = math.pi * math.sqrt(length / engine.settings.gravity) * (1.0 + angle * angle / 16.0)
        self._left = round(half_period / engine.settings.step)

    def step(self) -> bool:
        """Let it swing; the engine does."""
        self._left -= 1
        if self._left > 0:
            return True
        self._engine.remove(self.thing)
        return False
