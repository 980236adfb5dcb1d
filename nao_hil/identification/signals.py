"""Signals of a recording, on a grid of one row per cycle."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bridge.body.joints import JOINTS
from bridge.messages.elements import ELEMENTS

Array = NDArray[np.float64]
NAMES: Final = {
    "command": JOINTS,
    **{
        name: ELEMENTS[name] for name in ("stiffness", "position", "accelerometer", "gyroscope", "angle", "fsr")
    },
}
"""Columns of each signal by their names."""
COMMANDS: Final = ("command", "stiffness")
"""Signals that are asked for; the others are measured."""


@dataclass(frozen=True)
class Signals:
    """Commands and measurements, row k at the boundary of cycle k; NaN where nothing is known.

    Joints are in the order of `nao_hil.JOINTS`; units are SI and radians.
    """

    time: Array
    """s, (n,), evenly spaced from 0."""
    command: Array
    """Angles asked for in the cycle that begins at the row, (n, 25)."""
    stiffness: Array
    """Asked for in the same cycle, (n, 25)."""
    position: Array
    """Measured joint angles, (n, 25)."""
    accelerometer: Array
    """(n, 3)"""
    gyroscope: Array
    """(n, 3)"""
    angle: Array
    """Fused roll and pitch of the torso, (n, 2)."""
    fsr: Array
    """Force cells, left foot first, (n, 8), N."""
    measured: NDArray[np.bool_]
    """Rows at which something was measured, (n,); the measurements of the others are interpolated."""

    @property
    def cycle(self) -> float:
        """Time from one row to the next, s."""
        return float(self.time[1] - self.time[0])

    def part(self, rows: slice) -> Signals:
        """Some of the rows; their time begins at 0."""
        values: dict[str, Any] = {field.name: getattr(self, field.name)[rows] for field in fields(self)}
        values["time"] = values["time"] - values["time"][0]
        return Signals(**values)
