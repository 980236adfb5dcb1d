"""Zero moment point: of the pendulum (Prenner 2011, 3.2) and from the force sensors of the feet.

Frames are right-handed with z up. A moment about +y presses the front of the foot down and moves the point
forward; one about +x presses the right edge down and moves it to the right: (3.2b) has the wrong sign there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bridge.datasheet.model import Body, Side
from walker.errors import NoSupportError
from walker.gravity import GRAVITY
from walker.kinematics.transforms import Array, Transform


def pendulum_zmp(
    com: Sequence[float] | Array,
    acceleration: Sequence[float] | Array,
    *,
    mass: float,
    moment: tuple[float, float] = (0.0, 0.0),
) -> tuple[float, float]:
    """Zero moment point of the inverted pendulum on the ground z = 0 ((3.2); (3.3) without a moment).

    Args:
        com: Position of the centre of mass, shape (3,), m.
        acceleration: Of the centre of mass, shape (3,), m/s^2.
        mass: kg.
        moment: External moment on the robot about x and y, N m.

    Returns:
        x and y, m.

    Raises:
        NoSupportError: The centre of mass falls freely or faster, so nothing presses on the ground.
    """
    x, y, z = com
    a_x, a_y, a_z = acceleration
    lift = a_z + GRAVITY
    if not lift > 0.0:
        raise NoSupportError(
            f"no zero moment point: an upward acceleration of {a_z:.3g} m/s^2 leaves no weight on the ground, "
            f"it must exceed {-GRAVITY} m/s^2"
        )
    return (
        float(x - a_x * z / lift + moment[1] / (lift * mass)),
        float(y - a_y * z / lift - moment[0] / (lift * mass)),
    )


@dataclass(frozen=True)
class LinearPendulum:
    """The pendulum of constant height (3.4), one horizontal direction at a time."""

    height: float
    """Of the centre of mass above the ground, m."""

    @property
    def nu(self) -> float:
        """Natural frequency sqrt(g / z), 1/s."""
        return math.sqrt(GRAVITY / self.height)

    def zmp(self, position: float, acceleration: float) -> float:
        """Zero moment point, m, for the centre of mass' position (m) and acceleration (m/s^2) (3.4)."""
        return position - acceleration * self.height / GRAVITY

    def after(self, time: float, position: float, velocity: float, zmp: float) -> tuple[float, float]:
        """Position (m) and velocity (m/s) after a time (s) with the zero moment point resting at `zmp` (m)."""
        cosh, sinh = math.cosh(self.nu * time), math.sinh(self.nu * time)
        lean = position - zmp
        return zmp + lean * cosh + velocity / self.nu * sinh, lean * self.nu * sinh + velocity * cosh

    def capture_point(self, position: float, velocity: float) -> float:
        """Where the zero moment point must rest for the centre of mass to come to rest above it, m."""
        return position + velocity / self.nu


class FootForces:
    """Zero moment points from the four force sensors of each foot.

    Args:
        body: The data sheet: places of the sensors.
        least: Force below which a foot, or both together, bear no load worth a place, N.
    """

    def __init__(self, body: Body, least: float = 1.0) -> None:
        self._places: dict[Side, Array] = {
            "L": np.column_stack([np.array(body.fsr.L), np.ones(4)]),
            "R": np.column_stack([np.array(body.fsr.R), np.ones(4)]),
        }
        self._least = least

    def centre_of_pressure(self, side: Side, forces: Sequence[float]) -> tuple[float, float] | None:
        """Centre of pressure of one foot, AnkleRoll frame projected to the sole, m; None without load.

        Args:
            side: The foot.
            forces: FL, FR, RL, RR, along the sole's normal, N. A negative reading counts as zero.
        """
        point = self._mean([(side, np.eye(4), forces)])
        return None if point is None else (float(point[0]), float(point[1]))

    def zmp(self, fsr: Sequence[float], feet: Mapping[Side, Transform]) -> Array | None:
        """Zero moment point of the feet that stand, shape (3,), m; None without load.

        The mean of the sensors' places, weighted with the vertical parts of their forces: exact where the soles
        lie in one horizontal plane, the usual approximation where they do not.

        Args:
            fsr: A sensor frame's eight forces: left FL, FR, RL, RR, then right, N.
            feet: Poses of the feet to count (frame 8, AnkleRoll), shape (4, 4), m, in one frame with z up.
        """
        share = {"L": fsr[:4], "R": fsr[4:]}
        return self._mean([(side, pose, share[side]) for side, pose in feet.items()])

    def _mean(self, loads: Sequence[tuple[Side, Transform, Sequence[float]]]) -> Array | None:
        total, moment = 0.0, np.zeros(3)
        for side, pose, forces in loads:
            upward = np.maximum(forces, 0.0) * pose[2, 2]
            moment += (upward @ self._places[side]) @ pose[:3].T
            total += float(upward.sum())
        return moment / total if self._least < total < math.inf else None
