"""The inertial unit in the torso: accelerometer, gyroscope, and the angle fused from the two."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from bridge.datasheet.model import InertialUnit
from bridge.messages import Vec2, Vec3
from emulator.mechanics import TorsoState
from emulator.vectors import add, cross, length, rotate, rotate_back, scaled

CORRECTION_RATE: Final = 1.0
"""How fast the accelerometer pulls the fused angle at rest, 1/s (assumed)."""
ACCELERATION_SCALE: Final = 0.2
"""Departure of |acceleration| from gravity that halves the pull, m/s^2 (assumed)."""
RATE_SCALE: Final = 0.1
"""Rate of turn that halves the pull, rad/s (assumed)."""


class FusedAngle:
    """AngleX and AngleY as the vendor describes them: accelerometer at rest, gyroscope in motion.

    The direction up is turned by the gyroscope and pulled towards the accelerometer, the less the more the
    body moves. With R = Rz Ry Rx the torso's orientation, up in the Torso frame is
    (-sin AngleY, cos AngleY sin AngleX, cos AngleY cos AngleX).

    Args:
        gravity: m/s^2.
        acceleration: First accelerometer sample, m/s^2; the angle starts exactly there.
    """

    def __init__(self, gravity: float, acceleration: Vec3) -> None:
        self._gravity = gravity
        self._rate: Vec3 = (0.0, 0.0, 0.0)
        self._up = _unit(acceleration)

    def update(self, acceleration: Vec3, rate: Vec3, dt: float) -> None:
        """Take in one sample of both sensors, dt seconds after the last one."""
        turn = scaled(add(self._rate, rate), 0.5 * dt)
        self._rate = rate
        # up is fixed in the world, so in the torso it turns the other way; to second order in the angle
        way = cross(self._up, turn)
        up = add(self._up, add(way, scaled(cross(way, turn), 0.5)))
        size = length(acceleration)
        if size > 0.0:
            a = (size - self._gravity) / ACCELERATION_SCALE
            r = length(rate) / RATE_SCALE
            pull = CORRECTION_RATE * dt / ((1.0 + a * a) * (1.0 + r * r))
            up = add(scaled(up, 1.0 - pull), scaled(acceleration, pull / size))
        self._up = _unit(up)

    @property
    def angle(self) -> Vec2:
        """AngleX (roll) and AngleY (pitch), rad."""
        x, y, z = self._up
        return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))


def _unit(vector: Vec3) -> Vec3:
    size = length(vector)
    return scaled(vector, 1.0 / size) if size > 0.0 else (0.0, 0.0, 1.0)


class InertialSample(NamedTuple):
    """One sample of the unit, Torso frame."""

    acceleration: Vec3
    """Specific force, m/s^2."""
    rate: Vec3
    """Angular velocity, rad/s; 0 about an axis the unit does not have."""
    angle: Vec2
    """Fused AngleX and AngleY, rad."""


class InertialSensors:
    """The unit of a body, sampled once per cycle.

    The accelerometer gives the mean specific force of the cycle at its place: change of velocity over the
    cycle's physics steps, seen in the mean of the torso's orientations at both ends. The gyroscope gives the
    rate at the end of the cycle.

    Args:
        unit: Places and axes (data sheet).
        gravity: m/s^2.
        cycle: s.
        torso: The torso at the first sample, taken to be at rest.
    """

    def __init__(self, unit: InertialUnit, gravity: float, cycle: float, torso: TorsoState) -> None:
        self._place = unit.accelerometer
        self._third_axis = 1.0 if unit.gyroscope_axes == 3 else 0.0
        self._up: Vec3 = (0.0, 0.0, gravity)
        self._cycle = cycle
        self._rotation = torso.rotation
        self._velocity = self._point_velocity(torso)
        acceleration = rotate_back(torso.rotation, self._up)
        self._fusion = FusedAngle(gravity, acceleration)
        self.sample = InertialSample(acceleration, (0.0, 0.0, 0.0), self._fusion.angle)
        """The latest sample."""

    def _point_velocity(self, torso: TorsoState) -> Vec3:
        return add(torso.velocity, cross(torso.angular_velocity, rotate(torso.rotation, self._place)))

    def update(self, torso: TorsoState) -> None:
        """Sample at the end of a cycle."""
        velocity = self._point_velocity(torso)
        change = add(velocity, scaled(self._velocity, -1.0))
        specific = add(scaled(change, 1.0 / self._cycle), self._up)
        seen = add(rotate_back(self._rotation, specific), rotate_back(torso.rotation, specific))
        x, y, z = rotate_back(torso.rotation, torso.angular_velocity)
        rate = (x, y, z * self._third_axis)
        acceleration = scaled(seen, 0.5)
        self._fusion.update(acceleration, rate, self._cycle)
        self._velocity, self._rotation = velocity, torso.rotation
        self.sample = InertialSample(acceleration, rate, self._fusion.angle)
