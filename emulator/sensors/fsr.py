"""Force sensors of a foot: the ground's push on the sole, distributed among four cells.

The sole is a rigid plate on four equal springs that can only push. Its forces are affine in the cells' places,
which makes them the forces of least norm with the right sum and moments; a cell that would have to pull has
none, and the other three are then given by statics alone.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from bridge.types import Array, Vec2, Vec3
from emulator.compiled import compiled
from emulator.sensors.parameters import FsrParameters, NormalRows

CELLS: Final = 8
Cells = tuple[float, float, float, float]
NO_LOAD: Cells = (0.0, 0.0, 0.0, 0.0)


class ForceCells:
    """Dead band, gain, offset, drift, noise, range and quantisation, in this order.

    The drift of each cell is a first-order Gauss-Markov process that has been going on before the start.

    Args:
        max_force: Range of a cell, N (data sheet).
        cycle: Time between two readings, s.
        parameters: Imperfections.
        random: A generator of their own.
    """

    def __init__(
        self, max_force: float, cycle: float, parameters: FsrParameters, random: np.random.Generator
    ) -> None:
        constants, drift, noise, common = random.spawn(4)
        p = parameters
        self.gain: Array = (1.0 + p.common_gain * common.standard_normal()) * (
            1.0 + p.gain * constants.standard_normal(CELLS)
        )
        """Reading per force, cell by cell."""
        self.offset: Array = p.offset * constants.standard_normal(CELLS)
        """Offset of each cell, N."""
        self._max_force = max_force if p.saturation else math.inf
        self._step, self._dead_band, self._noise = p.step, p.dead_band, p.noise
        self._drifts, self._noises = NormalRows(drift, CELLS), NormalRows(noise, CELLS)
        self._drift_decay = math.exp(-cycle / p.drift_time)
        self._drift_step = p.drift * math.sqrt(1.0 - self._drift_decay**2)
        self.drift: Array = p.drift * self._drifts.next()
        """Present drift of the offsets, N."""

    def read(self, forces: Array) -> tuple[float, ...]:
        """Readings of all cells for the forces on them, (8,), N; once per cycle."""
        self.drift, readings = _read(
            forces,
            self._dead_band,
            self.gain,
            self.offset,
            self.drift,
            self._drift_decay,
            self._drift_step,
            self._drifts.next(),
            self._noise,
            self._noises.next(),
            self._step,
            self._max_force,
        )
        return tuple(readings.tolist())


@compiled
def _read(
    forces: Array,
    dead_band: float,
    gain: Array,
    offset: Array,
    before: Array,
    drift_decay: float,
    drift_step: float,
    wander: Array,
    deviation: float,
    noise: Array,
    step: float,
    max_force: float,
) -> tuple[Array, Array]:
    """The drift after a cycle, and the readings with it."""
    drift, readings = np.empty(CELLS), np.empty(CELLS)
    for i in range(CELLS):
        drift[i] = before[i] * drift_decay + drift_step * wander[i]
        felt = forces[i] if forces[i] >= dead_band else 0.0
        reading = felt * gain[i] + offset[i] + drift[i] + deviation * noise[i]
        if step > 0.0:
            reading = round(reading / step) * step
        # a cell can be pressed only
        readings[i] = min(max(reading, 0.0), max_force)
    return drift, readings


class FootForceSensors:
    """The four cells of one foot.

    Args:
        places: FL, FR, RL, RR in the AnkleRoll frame, m (data sheet).
    """

    def __init__(self, places: tuple[Vec3, Vec3, Vec3, Vec3]) -> None:
        xy = [(place[0], place[1]) for place in places]
        statics = np.array([[1.0] * 4, [p[0] for p in xy], [p[1] for p in xy]])
        self._least_norm = np.linalg.pinv(statics)
        self._inner = np.linalg.svd(statics)[2][3].copy()
        """Forces in balance with each other: the one other way to distribute a load."""
        fl, fr, rl, rr = xy
        self._outline = np.array([fl, rl, rr, fr])
        """Counter-clockwise."""

    def distribute(self, force: float, cop: Vec2 | None) -> Cells:
        """Forces on FL, FR, RL, RR along the sole normal, N.

        Their sum is the force; their centre of pressure is the true one where it is between the cells, else
        the nearest point that does.

        Args:
            force: Total normal force, N.
            cop: True centre of pressure in the sole frame, m; None without load.
        """
        if cop is None or force <= 0.0:
            return NO_LOAD
        return _distribute(force, cop[0], cop[1], self._least_norm, self._inner, self._outline)


@compiled
def _nearest_inside(x: float, y: float, outline: Array) -> Vec2:
    """The point itself between the cells, else the nearest point of their outline."""
    inside, nearest, smallest = True, (x, y), np.inf
    for i in range(4):
        ax, ay = outline[i]
        bx, by = outline[(i + 1) % 4]
        ex, ey, px, py = bx - ax, by - ay, x - ax, y - ay
        inside = inside and ex * py - ey * px >= 0.0
        t = min(1.0, max(0.0, (px * ex + py * ey) / (ex * ex + ey * ey)))
        place = (ax + t * ex, ay + t * ey)
        distance = (place[0] - x) ** 2 + (place[1] - y) ** 2
        if distance < smallest:
            nearest, smallest = place, distance
    return (x, y) if inside else nearest


@compiled
def _distribute(force: float, x: float, y: float, least_norm: Array, inner: Array, outline: Array) -> Cells:
    x, y = _nearest_inside(x, y, outline)
    plate = least_norm[:, 0] + least_norm[:, 1] * x + least_norm[:, 2] * y
    low, high = -np.inf, np.inf
    for i in range(4):
        if inner[i] > 1e-12:
            low = max(low, -plate[i] / inner[i])
        elif inner[i] < -1e-12:
            high = min(high, -plate[i] / inner[i])
    shift = min(max(0.0, low), high)
    cells = force * np.maximum(0.0, plate + shift * inner)
    return cells[0], cells[1], cells[2], cells[3]
