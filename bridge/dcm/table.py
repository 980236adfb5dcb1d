"""The actuators of one body as arrays: their slots in the frames, and the integers of their boards (counts)."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import INDEX, N_JOINTS
from bridge.dcm.actuators import Actuator, actuators, driven_joints
from bridge.types import Array

Places = NDArray[np.int_]


class ActuatorTable:
    """Rows: positions of the driven joints, their stiffnesses in the same order, LEDs, discrete actuators.

    Args:
        body: data sheet.
    """

    def __init__(self, body: Body) -> None:
        self.rows: tuple[Actuator, ...] = actuators(body)
        self.index = {actuator.name: i for i, actuator in enumerate(self.rows)}
        """Row of each name, without the prefix."""
        self.slots = [INDEX[joint] for joint in driven_joints(body)]
        """Frame slot of each driven joint."""
        self.n_joints = len(self.slots)
        self._frame = np.arange(2 * self.n_joints)
        self._wanted = np.array(self.slots + [N_JOINTS + slot for slot in self.slots])
        """Of each row of a frame: its place among 25 positions and 25 stiffnesses."""
        self._gain = np.array([actuator.gain for actuator in self.rows])
        self._offset = np.array([actuator.offset for actuator in self.rows])
        # Rounded inwards, so that no integer stands for a value beyond the range.
        lower = np.array([actuator.lower for actuator in self.rows])
        upper = np.array([actuator.upper for actuator in self.rows])
        self._lower = np.ceil((lower - self._offset) / self._gain - 1e-9)
        self._upper = np.floor((upper - self._offset) / self._gain + 1e-9)
        # the other way round, 0 for joints that the body lacks
        self._rows_sent = np.zeros(2 * N_JOINTS, dtype=int)
        self._gain_sent, self._offset_sent = np.zeros((2, 2 * N_JOINTS))
        self._rows_sent[self._wanted] = self._frame
        self._gain_sent[self._wanted] = self._gain[self._frame]
        self._offset_sent[self._wanted] = self._offset[self._frame]

    def to_counts(self, row: int, value: float) -> float:
        """A value of an actuator as its board's integer, inside the range."""
        actuator = self.rows[row]
        counts = round(min(max((value - actuator.offset) / actuator.gain, -1e9), 1e9))
        return float(min(max(counts, self._lower[row]), self._upper[row]))

    def value(self, row: int, counts: float) -> float:
        """Value that the board of an actuator reads back for counts that are not rounded yet."""
        return float(np.rint(counts) * self._gain[row] + self._offset[row])

    def frame_rows(self, without: Collection[int] = ()) -> Places:
        """Rows that a frame sets: of all positions and stiffnesses, but of those slots."""
        if not without:
            return self._frame
        kept = [row for row in range(len(self._frame)) if self.slots[row % self.n_joints] not in without]
        return np.array(kept, dtype=int)

    def frame_counts(self, position: Sequence[float], stiffness: Sequence[float]) -> Array:
        """Counts of all positions and stiffnesses, inside their ranges, shape (2 n_joints,).

        Args:
            position: 25 in frame order, rad (hands: 0..1).
            stiffness: 25 in frame order.
        """
        n = len(self._frame)
        counts: Array = np.array((*position, *stiffness), dtype=np.float64).take(self._wanted)
        counts -= self._offset[:n]
        counts /= self._gain[:n]
        np.rint(counts, out=counts)
        np.maximum(counts, self._lower[:n], out=counts)
        np.minimum(counts, self._upper[:n], out=counts)
        return counts

    def frame_values(self, counts: Array) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """25 positions and 25 stiffnesses in frame order, 0 for absent joints, of counts, shape (rows,)."""
        sent = np.rint(counts.take(self._rows_sent))
        sent *= self._gain_sent
        sent += self._offset_sent
        values = tuple(sent.tolist())
        return values[:N_JOINTS], values[N_JOINTS:]
