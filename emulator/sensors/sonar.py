"""Ultrasound in the chest: distance of the nearest thing that sends the echo back."""

from __future__ import annotations

import math
import operator
from typing import Final

import numpy as np

from bridge.types import Array, Vec2, Vec3
from emulator.compiled import compiled
from emulator.engine.base import Engine, Multibody
from emulator.engine.values import BodyState
from emulator.sensors.parameters import NormalRows, SonarParameters
from emulator.vectors import Rotation, add, put, rotate

MIN_DISTANCE: Final = 0.25
MAX_DISTANCE: Final = 2.55
"""m (vendor); things below read as the minimum, no echo reads as the maximum."""
PERIOD: Final = 0.1
"""Time between two echoes, s (vendor, periodic mode; taken to be always on)."""
PLACE: Final = (0.0507, 0.03785, 0.06035)
"""Place of the left sensor, Torso frame, m; the right one mirrors y (vendor's URDF of the V4)."""
DOWN: Final = 0.04365
OUTWARD: Final = 0.39265
"""Directions of the axis, rad (vendor's URDF of the V4)."""
CONE: Final = (0.13, 0.26)
"""Half angles of the rings of rays around the axis, rad: a field of view of 30 degrees (assumed)."""
RAYS_PER_RING: Final = 6
GRAZING: Final = 0.5
"""A surface hit at more than 60 degrees off its normal mirrors the sound away (assumed), as the floor does."""
OWN_BODY_LAYERS: Final = 4
"""Number of the robot's own links that a ray may pass; it does not sense itself (assumed)."""


def _rays(side: float) -> Array:
    """Unit vectors of one sensor's rays, (n, 3), Torso frame; side is 1 left, -1 right."""
    sy, cy = math.sin(side * OUTWARD), math.cos(side * OUTWARD)
    sp, cp = math.sin(DOWN), math.cos(DOWN)
    to_torso: Rotation = (cy * cp, -sy, cy * sp, sy * cp, cy, sy * sp, -sp, 0.0, cp)
    rays = [rotate(to_torso, (1.0, 0.0, 0.0))]
    for half in CONE:
        for k in range(RAYS_PER_RING):
            turn = 2.0 * math.pi * k / RAYS_PER_RING
            ray = (math.cos(half), math.sin(half) * math.cos(turn), math.sin(half) * math.sin(turn))
            rays.append(rotate(to_torso, ray))
    return np.array(rays)


class Sonars:
    """Both sensors.

    Args:
        engine: The world.
        robot: Whose own links its rays pass.
        parameters: Imperfections.
        cycle: Time between two updates, s.
        random: A generator of their own.
    """

    def __init__(
        self,
        engine: Engine,
        robot: Multibody,
        parameters: SonarParameters,
        cycle: float,
        random: np.random.Generator,
    ) -> None:
        self._engine, self._robot = engine, robot
        self._noise, self._step = parameters.noise, parameters.step
        self._rows = NormalRows(random, 2)
        self._every = max(1, round(PERIOD / cycle))
        self._cycles = 0
        self._left, self._right = _rays(1.0), _rays(-1.0)
        self._reading: Vec2 = (MAX_DISTANCE, MAX_DISTANCE)

    def update(self, torso: BodyState) -> None:
        """One cycle; every tenth of a second both sensors listen."""
        if self._cycles % self._every == 0:
            left = self._distance(torso, PLACE, self._left)
            right = self._distance(torso, (PLACE[0], -PLACE[1], PLACE[2]), self._right)
            a, b = self._rows.next().tolist()
            self._reading = self._report(left, a), self._report(right, b)
        self._cycles += 1

    def read(self) -> Vec2:
        """Left and right distance, m."""
        return self._reading

    def _report(self, distance: float, noise: float) -> float:
        if distance >= MAX_DISTANCE:
            return MAX_DISTANCE
        distance += self._noise * noise
        if self._step > 0.0:
            distance = round(distance / self._step) * self._step
        return min(max(distance, MIN_DISTANCE), MAX_DISTANCE)

    def _distance(self, torso: BodyState, place: Vec3, rays: Array) -> float:
        """Distance of the nearest echo of one sensor, m; infinite without one."""
        origin = np.array(add(torso.position, rotate(torso.rotation, place)))
        ways: Array = _turned(torso.rotation, rays)
        begin: Array = np.zeros((len(rays), 1))
        nearest = math.inf
        for _ in range(OWN_BODY_LAYERS):
            hits = self._engine.rays(origin + ways * begin, origin + ways * MAX_DISTANCE)
            again = []
            for i, (way, at, hit) in enumerate(zip(ways.tolist(), begin[:, 0].tolist(), hits, strict=True)):
                distance = at + hit.fraction * (MAX_DISTANCE - at)
                if hit.robot is self._robot:
                    again.append(i)
                    begin[i] = distance + 1e-3
                elif hit.kind != "nothing" and -sum(map(operator.mul, hit.normal, way)) > GRAZING:
                    nearest = min(nearest, distance)
            if not again:
                break
            ways, begin = ways[again], begin[again]
        return nearest


@compiled
def _turned(rotation: Rotation, rays: Array) -> Array:
    """Vectors of the torso, (n, 3), in the world."""
    turned = np.empty_like(rays)
    for i in range(len(rays)):
        put(turned[i], rotate(rotation, (rays[i, 0], rays[i, 1], rays[i, 2])))
    return turned
