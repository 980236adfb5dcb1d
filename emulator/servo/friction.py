"""Dry friction of the gears: a brush that bends before it slides.

    f = -clip(k (q - a) + d qd, -F, F),   the foot a of the brush dragged along at |q - a| = F / k

Within the brush's reach a joint sticks like a spring, beyond it the friction is Coulomb's. PyBullet's own
velocity motors would hold it without that millirad of deflection, but on every joint they make a physics step
two to three times as long (measured).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
REACH: Final = 0.001
"""How far the brush bends, rad: less than one count of the encoder (assumed)."""


class DryFriction:
    """Friction of all joints.

    Args:
        limit: F, maximum friction of each joint, N m.
        inertia: Of each rotor at its joint, kg m^2: the brush's own damping is half critical for it.
        position: Angles at the start, where every brush stands straight, rad.
    """

    def __init__(self, limit: Vector, inertia: Vector, position: Vector) -> None:
        self._limit, self._min = limit, -limit
        self._stiffness = limit / REACH
        self._damping = np.sqrt(self._stiffness * inertia)
        self._foot = position.copy()
        self._bend, self._work = np.zeros((2, len(limit)))

    def resist(self, position: Vector, velocity: Vector, torque: Vector) -> None:
        """Subtract the friction of a step from the torques, in place.

        Args:
            position: Joint angles, (n,), rad.
            velocity: Joint velocities, (n,), rad/s.
            torque: Of the drives, (n,), N m; changed.
        """
        bend, work = self._bend, self._work
        # bend = clip(q - a, -reach, reach), a follows; then f = clip(k bend + d qd, -F, F) is subtracted
        np.subtract(position, self._foot, out=bend)
        np.minimum(bend, REACH, out=bend)
        np.maximum(bend, -REACH, out=bend)
        np.subtract(position, bend, out=self._foot)
        bend *= self._stiffness
        np.multiply(velocity, self._damping, out=work)
        bend += work
        np.minimum(bend, self._limit, out=bend)
        np.maximum(bend, self._min, out=bend)
        torque -= bend
