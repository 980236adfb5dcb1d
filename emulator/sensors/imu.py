"""The inertial unit in the torso: accelerometer, gyroscope, and the angle fused from the two."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.datasheet.model import InertialUnit
from bridge.messages import Vec2
from emulator.mechanics import TorsoState

Vector = NDArray[np.float64]

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

    def __init__(self, gravity: float, acceleration: Vector) -> None:
        self._gravity = gravity
        self._rate = np.zeros(3)
        self._up = _unit(acceleration)

    def update(self, acceleration: Vector, rate: Vector, dt: float) -> None:
        """Take in one sample of both sensors, dt seconds after the last one."""
        turn = 0.5 * (self._rate + rate) * dt
        self._rate = rate
        # up is fixed in the world, so in the torso it turns the other way; to second order in the angle
        cross = np.cross(turn, self._up)
        up = self._up - cross + 0.5 * np.cross(turn, cross)
        size = float(np.linalg.norm(acceleration))
        if size > 0.0:
            a = (size - self._gravity) / ACCELERATION_SCALE
            r = float(np.linalg.norm(rate)) / RATE_SCALE
            pull = CORRECTION_RATE * dt / ((1.0 + a * a) * (1.0 + r * r))
            up = up + pull * (acceleration / size - up)
        self._up = _unit(up)

    @property
    def angle(self) -> Vec2:
        """AngleX (roll) and AngleY (pitch), rad."""
        x, y, z = self._up.tolist()
        return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))


def _unit(vector: Vector) -> Vector:
    size = float(np.linalg.norm(vector))
    return np.asarray(vector / size) if size > 0.0 else np.array([0.0, 0.0, 1.0])


class InertialSample(NamedTuple):
    """One sample of the unit, Torso frame."""

    acceleration: Vector
    """Specific force, m/s^2."""
    rate: Vector
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
        self._place = np.array(unit.accelerometer)
        self._axes = np.array([1.0, 1.0, 1.0 if unit.gyroscope_axes == 3 else 0.0])
        self._up = np.array([0.0, 0.0, gravity])
        self._cycle = cycle
        self._rotation = torso.rotation
        self._velocity = self._point_velocity(torso)
        acceleration = torso.rotation.T @ self._up
        self._fusion = FusedAngle(gravity, acceleration)
        self.sample = InertialSample(acceleration, self._axes * 0.0, self._fusion.angle)
        """The latest sample."""

    def _point_velocity(self, torso: TorsoState) -> Vector:
        return np.asarray(torso.velocity + np.cross(torso.angular_velocity, torso.rotation @ self._place))

    def update(self, torso: TorsoState) -> None:
        """Sample at the end of a cycle."""
        velocity = self._point_velocity(torso)
        specific = (velocity - self._velocity) / self._cycle + self._up
        acceleration = np.asarray(0.5 * (self._rotation + torso.rotation).T @ specific)
        rate = np.asarray(self._axes * (torso.rotation.T @ torso.angular_velocity))
        self._fusion.update(acceleration, rate, self._cycle)
        self._velocity, self._rotation = velocity, torso.rotation
        self.sample = InertialSample(acceleration, rate, self._fusion.angle)
