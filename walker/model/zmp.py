"""Zero moment point from the force sensors of the feet."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from bridge.body.model import Body
from bridge.types import Array, Side
from walker.model.transforms import Transform


class FootForces:
    """Zero moment points from the four force sensors of each foot.

    Args:
        body: The data sheet: places of the sensors.
        min_force: Force below which a foot, or both together, bear no load worth a place, N.
    """

    def __init__(self, body: Body, min_force: float = 1.0) -> None:
        self._places: dict[Side, Array] = {
            "L": np.column_stack([np.array(body.fsr.L), np.ones(4)]),
            "R": np.column_stack([np.array(body.fsr.R), np.ones(4)]),
        }
        self._min_force = min_force

    def zmp(self, fsr: Sequence[float], feet: Mapping[Side, Transform]) -> Array | None:
        """Zero moment point of the feet that stand, shape (3,), m; None without load.

        The mean of the sensors' places, weighted with the vertical parts of their forces: exact where the soles
        lie in one horizontal plane, the usual approximation where they do not.

        Args:
            fsr: A sensor frame's eight forces: left FL, FR, RL, RR, then right, N.
            feet: Poses of the feet to count (frame 8, AnkleRoll), shape (4, 4), m, in one frame with z up.
        """
        forces = {"L": fsr[:4], "R": fsr[4:]}
        return self._mean([(side, pose, forces[side]) for side, pose in feet.items()])

    def _mean(self, loads: Sequence[tuple[Side, Transform, Sequence[float]]]) -> Array | None:
        total, moment = 0.0, np.zeros(3)
        for side, pose, forces in loads:
            upward = np.maximum(forces, 0.0) * pose[2, 2]
            moment += (upward @ self._places[side]) @ pose[:3].T
            total += float(upward.sum())
        return moment / total if self._min_force < total < math.inf else None
